"""A LiDAR that leans: its points stand in a level frame, where readers who take z for up find them in their boxes."""

import json
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import (
    CAMERA,
    PALLET,
    RENDERER,
    T_CAMERA_LIDAR,
    failures,
    make_dataset,
    make_manifest,
    make_scene,
    observe,
    sweep,
    with_recipe,
)
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome, read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.geometry.level_view import lean, upright
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.schema import Observation

MOUNTS = {
    "pitched": (-0.35, 0.0, 0.0),
    "rolled": (0.1, 0.5, 0.2),
    "hanging": (-0.35, np.pi, 0.0),
    "down": (-1.5, 0, 0.4),
}
"""Pitch (up), roll (right side down) and yaw (left) of the LiDAR (rad)."""


def tilted(name: str) -> np.ndarray:
    pitch, roll, yaw = MOUNTS[name]
    return T_CAMERA_LIDAR @ make_transform(rotation_z(yaw) @ rotation_y(-pitch) @ rotation_x(roll))


def leaning(observation: Observation, T_camera_lidar: np.ndarray) -> Observation:
    scene = make_scene(observation.scene_index)
    scan = sweep(scene, observation.T_world_camera @ T_camera_lidar)
    return observation.with_reading("lidar", scan, T_camera_lidar)


def write(root: Path, name: str) -> Path:
    pitch, roll, yaw = np.degrees(MOUNTS[name])
    mount = {"carrier": "upright", "pitch_deg": pitch, "roll_deg": roll, "yaw_deg": yaw}
    manifest = with_recipe(make_manifest(formats=("kitti", "bop")), {"sensors": {"lidar_mount": mount}})
    return make_dataset(root, manifest, change=lambda observation: leaning(observation, tilted(name)))


@cache
def made(folder: Path, name: str) -> Path:
    return write(folder / name, name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("leaning")


def calib_pose(path: Path) -> np.ndarray:
    rows = {line.split(":")[0]: line.split(":")[1].split() for line in path.read_text().splitlines()}
    return np.vstack([np.array(rows["Tr_velo_to_cam"], float).reshape(3, 4), [0, 0, 0, 1]])


@pytest.mark.parametrize("name", sorted(MOUNTS))
def test_points_are_where_they_were_and_z_is_up(folder: Path, name: str) -> None:
    root = made(folder, name)
    for scene in (0, 2):
        half = "testing" if scene == 2 else "training"
        for number, observation in enumerate(observe(make_scene(scene))):
            frame = f"{2 * scene + number:06d}"
            T = calib_pose(root / f"kitti/{half}/calib/{frame}.txt")
            assert np.abs(T[:3, 2] - [0, -1, 0]).max() < 1e-9  # up, in a level camera's frame
            assert np.abs(T[:3, 3] - T_CAMERA_LIDAR[:3, 3]).max() < 1e-9
            cloud = np.fromfile(root / f"kitti/{half}/velodyne/{frame}.bin", "<f4").reshape(-1, 4)[:, :3]
            ids = np.fromfile(root / f"kitti/{half}/velodyne_ids/{frame}.bin", "<i4")
            true = leaning(observation, tilted(name))
            in_camera = true.lidar.points @ tilted(name)[:3, :3].T + tilted(name)[:3, 3]
            assert np.abs(cloud @ T[:3, :3].T + T[:3, 3] - in_camera).max() < 1e-5
            assert (ids == true.lidar.instance_ids).all()
            recorded = read_scene_record(root, scene).observations[number]
            assert np.abs(recorded.T_camera_lidar - tilted(name)).max() < 1e-12


@pytest.mark.parametrize("name", ["hanging", "pitched", "rolled"])
def test_readers_that_take_z_for_up_find_the_points_in_the_boxes(folder: Path, name: str) -> None:
    """As OpenPCDet does: the bottom centre is led into the LiDAR's frame, half a height is added along its z."""
    root, counted = made(folder, name), 0
    for frame in ("000000", "000002"):
        T = calib_pose(root / f"kitti/training/calib/{frame}.txt")
        cloud = np.fromfile(root / f"kitti/training/velodyne/{frame}.bin", "<f4").reshape(-1, 4)[:, :3]
        ids = np.fromfile(root / f"kitti/training/velodyne_ids/{frame}.bin", "<i4")
        owners = (root / f"kitti/training/label_2_ids/{frame}.txt").read_text().split()
        rows = (root / f"kitti/training/label_2/{frame}.txt").read_text().splitlines()
        for row, owner in zip(rows, owners, strict=True):
            h, w, le, x, y, z, turn = map(float, row.split()[8:])
            centre = np.linalg.inv(T) @ [x, y, z, 1.0] + [0, 0, h / 2, 0]
            ahead = T[:3, :3].T @ [np.cos(turn), 0.0, -np.sin(turn)]
            heading = np.arctan2(ahead[1], ahead[0])
            local = (cloud - centre[:3]) @ rotation_z(heading)
            inside = (np.abs(local) <= np.array([le, w, h]) / 2 + 1e-3).all(axis=1)
            own = ids == int(owner)
            assert inside[own].all()
            counted += int(own.sum())
    assert counted > 10


@pytest.mark.parametrize("name", sorted(MOUNTS))
def test_validate_knows_the_frame(folder: Path, name: str) -> None:
    checks = validate(made(folder, name))
    # A sweep that looks straight down may miss the pallets; then no points are there to be judged.
    assert [check.detail for check in checks if not check.ok] == []


def test_points_that_were_left_as_measured_fail(folder: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made(folder, "pitched"), tmp_path / "data"))
    true = leaning(observe(make_scene(0))[0], tilted("pitched")).lidar
    rows = np.hstack([true.points, true.intensity[:, None]]).astype("<f4")
    (root / "kitti/training/velodyne/000000.bin").write_bytes(rows.tobytes())
    assert "kitti points in boxes" in list(failures(root))


def test_a_calibration_that_leans_fails(folder: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made(folder, "pitched"), tmp_path / "data"))
    path = root / "kitti/training/calib/000000.txt"
    lines = path.read_text().splitlines()
    T = tilted("pitched")[:3]
    lines[5] = "Tr_velo_to_cam: " + " ".join(f"{value:.12e}" for value in T.ravel())
    path.write_text("\n".join(lines) + "\n")
    (check,) = [check for check in validate(root) if check.name == "kitti calib"]
    assert "the z axis of the points leans by 20.05 deg" in check.detail


def test_a_lost_tilt_of_the_record_is_missed_by_the_rings(folder: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made(folder, "hanging"), tmp_path / "data"))
    path = root / "scenes/000000.json"
    record = json.loads(path.read_text())
    for row in record["observations"]:
        del row["T_camera_lidar"]
    path.write_text(json.dumps(record))
    failed = failures(root)
    assert "rings do not follow the elevation" in failed["kitti sweeps"]


def test_the_readme_says_so_only_where_it_happens(folder: Path, toy_root: Path) -> None:
    assert "The LiDAR may lean" in (made(folder, "pitched") / "kitti/README.md").read_text()
    assert "The LiDAR may lean" not in (toy_root / "kitti/README.md").read_text()


def test_within_two_degrees_points_stay_as_measured(tmp_path: Path) -> None:
    T = T_CAMERA_LIDAR @ make_transform(rotation_y(np.deg2rad(2.0)))
    observations = [leaning(observation, T) for observation in observe(make_scene(0))]
    store = DatasetStore(
        tmp_path, replace(make_manifest(formats=("kitti",)), scenes=1, splits={"train": (0,), "val": (), "test": ()})
    )
    store.begin([PALLET], CAMERA)
    store.write_scene(make_scene(0), observations, Outcome({"problems": [], "speed": 0.0}, RENDERER))
    cloud = np.fromfile(tmp_path / "kitti/training/velodyne/000000.bin", "<f4").reshape(-1, 4)[:, :3]
    assert (cloud == observations[0].lidar.points).all()
    assert read_scene_record(tmp_path, 0).observations[0].T_camera_lidar is None


def test_upright_keeps_place_and_heading() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        T = make_transform(np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3))
        T[:3, 0] *= np.sign(np.linalg.det(T[:3, :3]))
        up = upright(T)
        assert np.allclose(up[:3, 2], [0, 0, 1], atol=1e-12)
        assert np.allclose(up[:3, :3] @ up[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(up[:3, :3]) > 0
        assert (up[:3, 3] == T[:3, 3]).all()
    for pitch in np.deg2rad([-80, -10, 0, 30]):
        T = make_transform(rotation_z(0.7) @ rotation_y(-pitch))
        assert np.allclose(upright(T)[:3, :3], rotation_z(0.7))
        assert lean(T) == pytest.approx(abs(pitch), abs=1e-12)
    assert np.allclose(upright(make_transform(rotation_z(0.7) @ rotation_x(np.pi)))[:3, :3], rotation_z(0.7))
