"""What validate says of real sweeps of every LiDAR preset: right as they are, wrong when points or ids are."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.dataset.validate import Check, validate
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.render import Renderer
from warehouse_sim.schema import SceneSpec
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig

pytestmark = pytest.mark.gl


def recipe_of(lidar: LidarConfig) -> Recipe:
    recipe = load_recipe("smoke")
    return replace(recipe, sensors=replace(recipe.sensors, lidar=lidar))


@cache
def scene() -> SceneSpec:
    settled = sample_settled_scene(recipe_of(LidarConfig()), 0, 0).scene
    views = tuple(replace(view, velocity=(1.8, -0.6, 0.0), yaw_rate=0.4) for view in settled.viewpoints)
    return replace(settled, viewpoints=views)


def dataset(root: Path, lidar: LidarConfig, renderer: Renderer) -> Path:
    recipe = recipe_of(lidar)
    plan = plan_dataset(recipe, GenerateConfig(scenes=1, formats=("kitti",)))
    store = DatasetStore(root, plan.manifest)
    store.begin(plan.models, plan.camera)
    store.write_scene(scene(), observe_scene(scene(), recipe.sensors, renderer), Outcome({}, renderer.description))
    store.finish()
    return root


def points_check(root: Path) -> Check:
    (check,) = [check for check in validate(root) if check.name == "kitti points in boxes"]
    return check


# Not safety2d: its one ring passes above the pallets of this scene.
@pytest.mark.parametrize(
    ("name", "motion"),
    [
        ("hdl64e", "raw"),
        ("hdl64e_s2", "ignored"),
        ("vlp16", "raw"),
        ("os1_128", "deskewed"),
    ],
)
def test_sweeps_are_right_as_they_are_and_wrong_when_moved(
    renderer: Renderer, tmp_path: Path, name: str, motion: str
) -> None:
    root = dataset(tmp_path / "data", replace(LIDAR_PRESETS[name], motion=motion), renderer)
    check = points_check(root)
    assert check.ok, check.detail
    for path in sorted((root / "kitti").rglob("velodyne/*.bin")):
        cloud = np.fromfile(path, "<f4").reshape(-1, 4)
        path.write_bytes((cloud + np.array([0.0, 0.3, 0.0, 0.0], np.float32)).astype("<f4").tobytes())
    assert not points_check(root).ok
