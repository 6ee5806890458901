"""Points in boxes: what a sensor's noise explains passes, wrong points and wrong ids do not."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_scene, observe
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.dataset.validate import Check, validate
from warehouse_sim.sensors.lidar import LIDAR_PRESETS
from warehouse_sim.sensors.lidar.receiver import quantised, range_sigma, relative_power

REFLECTANCE = 0.25
"""Of every point of the toy's sweeps."""
STEPS = {"azimuth_step_deg": 360.0 / 359.0, "azimuth_range_deg": [-180.0, 180.0], "turns_per_second": 10.0}
"""Of the toy's sweeps."""
FRAMES = {0: "training", 1: "training", 2: "testing"}


def points_check(root: Path) -> Check:
    (check,) = [check for check in validate(root) if check.name == "kitti points in boxes"]
    return check


def with_lidar(root: Path, folder: Path, name: str, factor: float) -> Path:
    """Return a copy of the toy dataset whose sweeps have ``factor`` times the range noise of a preset."""
    copy = Path(shutil.copytree(root, folder))
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["recipe"]["sensors"] = {"lidar": to_mapping(LIDAR_PRESETS[name]) | STEPS}
    manifest["contents"] = to_mapping(recipe_contents(manifest["recipe"]))
    (copy / "manifest.json").write_text(json.dumps(manifest))
    rng, config = np.random.default_rng(5), LIDAR_PRESETS[name]
    for scene, split in FRAMES.items():
        path = copy / f"kitti/{split}/velodyne/{2 * scene:06d}.bin"
        points = observe(make_scene(scene))[0].lidar.points
        distance = np.linalg.norm(points, axis=1)
        sigma = range_sigma(relative_power(np.full_like(distance, REFLECTANCE), distance, config), config)
        noisy = quantised(distance + factor * sigma * rng.standard_normal(len(distance)), config.range_step)
        cloud = np.hstack([points * (noisy / distance)[:, None], np.full((len(points), 1), REFLECTANCE)])
        path.write_bytes(cloud.astype("<f4").tobytes())
    return copy


@pytest.mark.parametrize("name", sorted(LIDAR_PRESETS))
def test_noise_of_the_sensor_is_told_and_taken(toy_root: Path, tmp_path: Path, name: str) -> None:
    check = points_check(with_lidar(toy_root, tmp_path / "data", name, 1.0))
    assert check.ok, check.detail
    assert "m allowed along the beam" in check.detail


@pytest.mark.parametrize("name", ["hdl64e", "os1_128"])
def test_a_lot_more_noise_than_the_sensors_is_not(toy_root: Path, tmp_path: Path, name: str) -> None:
    assert not points_check(with_lidar(toy_root, tmp_path / "data", name, 20.0)).ok


def edit(root: Path, kind: str, dtype: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    path = root / f"kitti/training/{kind}/000000.bin"
    path.write_bytes(change(np.fromfile(path, dtype)).astype(dtype).tobytes())


def exchanged(ids: np.ndarray) -> np.ndarray:
    """Give the points of one pallet to another."""
    result = ids.copy()
    result[ids == 10], result[ids == 11] = 11, 10
    return result


@pytest.mark.parametrize(
    ("name", "axis"), [(None, 0), (None, 1), (None, 2), ("hdl64e", 0), ("vlp16", 1), ("os1_128", 2)]
)
def test_points_30_cm_off_fail(toy_root: Path, tmp_path: Path, name: str | None, axis: int) -> None:
    root = tmp_path / "data"
    with_lidar(toy_root, root, name, 1.0) if name else shutil.copytree(toy_root, root)
    step = np.zeros(4, np.float32)
    step[axis] = 0.3
    edit(root, "velodyne", "<f4", lambda cloud: (cloud.reshape(-1, 4) + step).ravel())
    assert not points_check(root).ok


@pytest.mark.parametrize("name", ["hdl64e", "vlp16", "os1_128", "safety2d"])
def test_exchanged_ids_fail(toy_root: Path, tmp_path: Path, name: str) -> None:
    root = with_lidar(toy_root, tmp_path / "data", name, 1.0)
    edit(root, "velodyne_ids", "<i4", exchanged)
    check = points_check(root)
    assert not check.ok
    assert "are outside its box, where neither noise (6 sigma: " in check.detail
