"""A dataset behind a lens: boxes, masks, depth and calibration stay right, and validation sees it if they do not."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.shared import Shared
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.formats.kitti.reader import calib_camera
from warehouse_sim.dataset.formats.kitti.tolerant import OUR_SHAPES, read_matrices
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.lens import Distortion, Fisheye
from warehouse_sim.sensors.rig import CAMERA_PRESETS, CalibrationConfig, CameraConfig
from warehouse_sim.sensors.stereo import StereoConfig

pytestmark = pytest.mark.gl
BROWN = Distortion(-0.3691481, 0.1968681, 0.001353473, 0.0005677587, -0.06770705)
FISHEYE = Fisheye(0.01, -0.004, 0.001, -0.0001)
"""130 degrees across."""
CAMERAS = {
    "distortion": CameraConfig(696, 256, 479.9, 347.8, 111.8, BROWN),
    "fisheye": CameraConfig(480, 270, 212.0, fisheye=FISHEYE),
}
"""By the key of BOP's camera file that holds the coefficients; the first has a second camera beside it."""
MORE = {"distortion": {"right": StereoConfig(baseline=0.3)}, "fisheye": {"calibration": CalibrationConfig()}}
CALIB, ROWS = "kitti/training/calib/000000.txt", "bop/train/000000/scene_camera.json"


@pytest.fixture(params=CAMERAS)
def key(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def root(key: str, shared: Shared) -> Path:
    recipe = load_recipe("smoke")
    return shared.dataset(replace(recipe, sensors=replace(recipe.sensors, camera=CAMERAS[key], **MORE[key])), scenes=1)


def failed(root: Path) -> set[str]:
    return {check.name for check in validate(root) if not check.ok}


def test_every_check_holds(root: Path) -> None:
    assert [check for check in validate(root) if not check.ok] == []


def test_both_formats_give_back_the_camera(key: str, root: Path) -> None:
    (image, *_) = DatasetReader(root).images("train")
    camera = CAMERAS[key].make()
    assert image.camera == camera
    matrices = read_matrices((root / CALIB).read_text(), CALIB, OUR_SHAPES)
    ending = {"distortion": ["K_02", "D_02", "K_03", "D_03"], "fisheye": ["K_02", "F_02"]}[key]
    assert list(matrices)[-len(ending) :] == ending
    assert calib_camera(matrices, (camera.width, camera.height)) == camera
    stored = json.loads((root / "bop/camera.json").read_text())
    assert stored[key] == list(camera.distortion.coefficients)
    assert len({"distortion", "fisheye"} & set(stored)) == 1


def test_the_surface_of_targets_fills_its_box_only_behind_the_lens(key: str, root: Path) -> None:
    """A pallet's own surface fills its box as the lens shows it, OpenCV's fisheye; by the pinhole it would not."""
    reader, offsets = DatasetReader(root), []
    for image in reader.images("all"):
        camera = image.camera
        for target in image.targets:
            points = reader.objects[target.obj_id].mesh().vertices @ target.T_camera_object[:3, :3].T
            points = points + target.T_camera_object[:3, 3]
            if points[:, 2].min() > 0.3:
                shown = camera.project(points)
                if key == "fisheye":
                    lens = np.array(FISHEYE.coefficients)
                    shown, _ = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), camera.K, lens)
                each = (shown.reshape(-1, 2), camera.pinhole.project(points))
                boxes = [np.concatenate([pixels.min(axis=0), pixels.max(axis=0)]) for pixels in each]
                if (boxes[0] > 0).all() and (boxes[0] < [camera.width, camera.height] * 2).all():
                    offsets.append([np.abs(box - target.box_amodal_xyxy).max() for box in boxes])
    assert len(offsets) >= 3
    behind_the_lens, by_the_pinhole = np.max(offsets, axis=0)
    assert behind_the_lens < 1.0
    assert by_the_pinhole > 3.0


def test_a_calib_with_another_lens_or_none_fails(key: str, root: Path, tmp_path: Path) -> None:
    path = shutil.copytree(root, tmp_path / "data") / CALIB
    text = path.read_text()
    old, new = {"distortion": ("D_02: -3.69", "D_02: -3.59"), "fisheye": ("F_02: 1.0", "F_02: 1.1")}[key]
    for changed in (text.replace(old, new), "".join(line + "\n" for line in text.splitlines()[:7])):
        assert changed != text
        path.write_text(changed)
        assert failed(tmp_path / "data") == {"kitti calib"}


@pytest.mark.parametrize("key", ["distortion"], indirect=True)
def test_a_dataset_that_forgot_its_lens_fails(root: Path, tmp_path: Path) -> None:
    path = shutil.copytree(root, tmp_path / "data") / ROWS
    rows = json.loads(path.read_text())
    for row in rows.values():
        del row["cam_distortion"]
    path.write_text(json.dumps(rows))
    assert failed(tmp_path / "data") == {"bop cameras", "bop poses on images"}


@pytest.mark.parametrize("key", ["distortion"], indirect=True)
def test_the_pages_of_both_formats_tell_of_the_lens(root: Path) -> None:
    assert "cam_distortion" in (root / "bop/dataset_info.md").read_text()
    assert "D_02" in (root / "kitti/README.md").read_text()


@pytest.mark.parametrize("key", ["fisheye"], indirect=True)
def test_a_nominal_camera_has_the_same_kind_of_lens(root: Path) -> None:
    nominal = read_scene_record(root, 0).observations[0].nominal
    assert nominal is not None
    assert isinstance(nominal.camera.distortion, Fisheye)


def test_the_preset_spans_130_degrees_and_two_lenses_are_rejected() -> None:
    camera = CAMERA_PRESETS["fisheye"].make()
    left, right = camera.rays_at(np.array([-0.5, camera.width - 0.5]), np.full(2, camera.cy))
    angle = np.degrees(np.arccos(left @ right / np.linalg.norm(left) / np.linalg.norm(right)))
    assert angle == pytest.approx(130.0, abs=0.1)
    assert from_mapping(CameraConfig, to_mapping(CAMERA_PRESETS["fisheye"]), "here") == CAMERA_PRESETS["fisheye"]
    with pytest.raises(ConfigError, match="two kinds of lens"):
        CameraConfig.from_plain({"preset": "fisheye", "distortion": {"k1": -0.1}}, "here")
    with pytest.raises(ConfigError, match=r"76\.0 deg off its axis"):
        CameraConfig.from_plain({"preset": "fisheye", "focal_px": 500}, "here")
