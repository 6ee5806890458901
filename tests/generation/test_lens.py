"""A dataset behind a lens: boxes, masks, depth and calibration stay right, and validation sees it if they do not."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.formats.kitti.reader import calib_camera, parse_calib
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.sensors.rig import CameraConfig
from warehouse_sim.sensors.stereo import StereoConfig

pytestmark = pytest.mark.gl

LENS = Distortion(-0.3691481, 0.1968681, 0.001353473, 0.0005677587, -0.06770705)


@pytest.fixture(scope="module")
def camera() -> CameraConfig:
    return CameraConfig(696, 256, 479.9, 347.8, 111.8, LENS)


@pytest.fixture(scope="module")
def root(camera: CameraConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    recipe = load_recipe("smoke")
    rig = replace(recipe.sensors, camera=camera, right=StereoConfig(baseline=0.3))
    root = tmp_path_factory.mktemp("lens") / "data"
    generate(replace(recipe, sensors=rig), root, GenerateConfig(scenes=2, seed=0))
    return root


def failed(root: Path) -> set[str]:
    return {check.name for check in validate(root) if not check.ok}


def test_every_check_holds(root: Path) -> None:
    checks = validate(root)
    assert [check for check in checks if not check.ok] == []
    assert len(checks) == 24  # those of both formats, and of the inertial unit's readings


def test_both_formats_give_back_the_camera(root: Path, camera: CameraConfig) -> None:
    (image, *_) = DatasetReader(root).images("train")
    assert image.camera == camera.make()
    path = root / "kitti/training/calib/000000.txt"
    matrices = parse_calib(path.read_text(), str(path))
    assert list(matrices)[-4:] == ["K_02", "D_02", "K_03", "D_03"]
    assert calib_camera(matrices, (696, 256)) == camera.make()
    assert "cam_distortion" in (root / "bop/dataset_info.md").read_text()
    assert "D_02" in (root / "kitti/README.md").read_text()
    assert json.loads((root / "bop/camera.json").read_text())["distortion"] == list(LENS.coefficients)


def test_corners_of_boxes_lie_in_their_2d_boxes_only_behind_the_lens(root: Path) -> None:
    """The pallet's own surface, projected, fills its box; by the pinhole it would not."""
    reader = DatasetReader(root)

    def worst(project: str) -> float:
        found = [0.0]
        for image in [*reader.images("train"), *reader.images("test")]:
            seen_by: PinholeCamera = getattr(image.camera, project) if project else image.camera
            for target in image.targets:
                points = reader.objects[target.obj_id].mesh().vertices
                moved = points @ target.T_camera_object[:3, :3].T + target.T_camera_object[:3, 3]
                if moved[:, 2].min() > 0.3:
                    pixels = seen_by.project(moved)
                    box = np.array([pixels.min(axis=0), pixels.max(axis=0)]).ravel()
                    inside = (box > 0).all() and (box < [696, 256, 696, 256]).all()
                    found.append(np.abs(box - target.box_amodal_xyxy).max() if inside else 0.0)
        return max(found)

    assert worst("") < 1.0
    assert worst("pinhole") > 3.0


def test_a_dataset_that_forgot_its_lens_fails(root: Path) -> None:
    path = root / "bop/train/000000/scene_camera.json"
    text = path.read_text()
    rows = json.loads(text)
    for row in rows.values():
        del row["cam_distortion"]
    path.write_text(json.dumps(rows))
    assert failed(root) == {"bop cameras", "bop poses on images", "kitti and bop cameras"}
    path.write_text(text)


def test_a_calib_with_another_lens_fails(root: Path) -> None:
    path = root / "kitti/training/calib/000000.txt"
    text = path.read_text()
    path.write_text(text.replace("D_02: -3.69", "D_02: -3.59"))
    assert failed(root) == {"kitti calib", "kitti and bop cameras"}
    path.write_text("".join(line + "\n" for line in text.splitlines()[:7]))
    assert failed(root) == {"kitti calib", "kitti and bop cameras"}
    path.write_text(text)
