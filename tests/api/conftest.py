from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.shared import Shared
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.schema import PoseEstimate
from warehouse_sim.sensors.rig.camera import CameraConfig


@pytest.fixture(scope="session")
def smoke(shared: Shared) -> Path:
    """Return three scenes of two small observations, one scene a split, in several formats; nobody changes it."""
    recipe = load_recipe("smoke")
    camera = CameraConfig(width=612, height=185, focal_px=360.0)
    recipe = replace(recipe, sensors=replace(recipe.sensors, camera=camera))
    return shared.dataset(recipe, scenes=3, formats=("bop", "kitti", "coco", "yolo"))


@pytest.fixture
def data(smoke: Path) -> Dataset:
    return Dataset(smoke)


@pytest.fixture
def oracle(data: Dataset) -> Callable[[RgbdImage], list[PoseEstimate]]:
    """Return an estimator that knows the ground truth."""
    known = {(obs.scene_id, obs.image_id): obs for obs in data}

    def estimate(image: RgbdImage) -> list[PoseEstimate]:
        place = image.scene_id, image.image_id
        return [PoseEstimate(*place, item.obj_id, 1.0, item.T_camera_object) for item in known[place].objects]

    return estimate
