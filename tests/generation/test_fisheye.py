"""A dataset behind a fisheye 130 deg across: every check holds, and both formats give the lens back by its own keys."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.formats.kitti.reader import calib_camera, parse_calib
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.fisheye import Fisheye
from warehouse_sim.sensors.rig import CAMERA_PRESETS, CalibrationConfig, CameraConfig

pytestmark = pytest.mark.gl
LENS = Fisheye(0.01, -0.004, 0.001, -0.0001)
CAMERA = CameraConfig(480, 270, 212.0, fisheye=LENS)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    recipe = load_recipe("smoke")
    rig = replace(recipe.sensors, camera=CAMERA, calibration=CalibrationConfig())
    root = tmp_path_factory.mktemp("fisheye") / "data"
    generate(replace(recipe, sensors=rig), root, GenerateConfig(scenes=2, seed=0))
    return root


def test_every_check_holds(root: Path) -> None:
    assert [check for check in validate(root) if not check.ok] == []


def test_both_formats_give_back_the_camera(root: Path) -> None:
    (image, *_) = DatasetReader(root).images("train")
    assert image.camera == CAMERA.make()
    assert image.camera.distortion == LENS
    path = root / "kitti/training/calib/000000.txt"
    matrices = parse_calib(path.read_text(), str(path))
    assert list(matrices)[-2:] == ["K_02", "F_02"]
    assert calib_camera(matrices, (480, 270)) == CAMERA.make()
    camera = json.loads((root / "bop/camera.json").read_text())
    assert camera["fisheye"] == list(LENS.coefficients)
    assert "distortion" not in camera
    nominal = read_scene_record(root, 0).observations[0].nominal
    assert nominal is not None
    assert isinstance(nominal.camera.distortion, Fisheye)


def test_the_surface_of_targets_fills_its_box_as_opencv_projects_it(root: Path) -> None:
    reader, compared = DatasetReader(root), 0
    for image in (image for split in reader.splits for image in reader.images(split)):
        for target in image.targets:
            points = reader.objects[target.obj_id].mesh().vertices @ target.T_camera_object[:3, :3].T
            points = points + target.T_camera_object[:3, 3]
            if points[:, 2].min() < 0.3:
                continue
            shown, _ = cv2.fisheye.projectPoints(
                points[:, None], np.zeros(3), np.zeros(3), image.camera.K, np.array(LENS.coefficients)
            )
            box = np.concatenate([shown[:, 0].min(axis=0), shown[:, 0].max(axis=0)])
            if (box > 0).all() and (box < [480, 270, 480, 270]).all():
                assert np.abs(box - target.box_amodal_xyxy).max() < 1.0
                compared += 1
    assert compared >= 3


def test_another_lens_in_the_calibration_fails(root: Path) -> None:
    path = root / "kitti/training/calib/000000.txt"
    text = path.read_text()
    path.write_text(text.replace("F_02: 1.0", "F_02: 1.1"))
    assert {check.name for check in validate(root) if not check.ok} == {"kitti calib", "kitti and bop cameras"}
    path.write_text(text)


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
