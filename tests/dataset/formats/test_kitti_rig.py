"""What the KITTI folder holds of a right camera and of further LiDARs."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.toy import CAMERA, T_CAMERA_LIDAR, failures, make_dataset, make_manifest, with_recipe
from warehouse_sim.dataset.files.image_io import encode_disparity
from warehouse_sim.dataset.formats.kitti import KITTI_KINDS, kitti_kinds
from warehouse_sim.dataset.formats.kitti.tolerant import OUR_SHAPES, read_matrices
from warehouse_sim.dataset.formats.kitti.writer import calib_text
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.dataset.validate import validate
from warehouse_sim.schema import Observation, StereoReading

SENSORS = {"right": {"baseline": 0.25, "matching": None}, "lidars": {"rear": {}}}


def with_more(observation: Observation) -> Observation:
    depth = observation.buffers.depth
    disparity = np.where(depth > 0, CAMERA.fx * 0.25 / np.maximum(depth, 0.1), 0.0).astype(np.float32)
    stereo = StereoReading(0.25, observation.rgbd.rgb[:, ::-1].copy(), observation.buffers, disparity, disparity < 5.0)
    assert observation.lidar is not None
    return observation.with_reading("right", stereo).with_reading("rear", observation.lidar, T_CAMERA_LIDAR)


def with_matched(observation: Observation) -> Observation:
    stereo = with_more(observation).stereo
    assert stereo is not None
    return observation.with_reading("right", replace(stereo, matched=stereo.disparity))


@pytest.fixture
def root(tmp_path: Path) -> Path:
    manifest = with_recipe(make_manifest(formats=("kitti",)), {"sensors": SENSORS})
    return make_dataset(tmp_path / "data", manifest, change=with_more)


def kinds_of(sensors: dict) -> dict[str, str]:
    return kitti_kinds(recipe_contents({"sensors": sensors}))


def test_kinds_follow_the_recipes_sensors() -> None:
    assert kinds_of({}) == kinds_of({"camera": {}}) == KITTI_KINDS
    added = {"image_3", "disp_occ", "disp_noc", "velodyne_rear", "velodyne_rear_ids", "calib_lidars"}
    assert set(kinds_of(SENSORS)) - set(KITTI_KINDS) == added
    matched = {"right": {"baseline": 0.25, "matching": {}}}
    assert set(kinds_of(matched)) - set(KITTI_KINDS) == {"image_3", "disp_occ", "disp_noc", "disp_sgbm"}


def test_the_folder_validates_and_names_what_is_wrong(root: Path) -> None:
    assert failures(root) == {}
    calib = root / "kitti/training/calib/000000.txt"
    P3 = read_matrices(calib.read_text(), "calib", OUR_SHAPES)["P3"]
    assert P3[0, 3] == pytest.approx(-110.0 * 0.25)
    calib.write_text(calib_text(CAMERA, T_CAMERA_LIDAR, 0.3))
    (broken,) = [check for check in validate(root) if not check.ok]
    assert "P3 must be P2 moved along x by the recipe's baseline" in broken.detail


@pytest.mark.parametrize(
    "text", ["\0" * 40, "Tr_rear_to_cam: " + "0 " * 11 + "0\n", "Tr_left_to_cam: 1 0 0 0 0 1 0 0 0 0 1 0\n"]
)
def test_poses_of_further_lidars_are_looked_at(root: Path, text: str) -> None:
    path = root / "kitti/training/calib_lidars/000000.txt"
    path.write_text(text)
    (broken,) = [check for check in validate(root) if not check.ok]
    assert (broken.name, str(path) in broken.detail) == ("kitti calib", True)


def test_matched_disparities_that_are_no_image_are_named(tmp_path: Path) -> None:
    manifest = with_recipe(
        make_manifest(formats=("kitti",)), {"sensors": {"right": {"baseline": 0.25, "matching": {}}}}
    )
    make_dataset(tmp_path / "data", manifest, change=with_matched)
    assert failures(tmp_path / "data") == {}
    path = tmp_path / "data/kitti/training/disp_sgbm/000000.png"
    path.write_bytes(bytes(path.stat().st_size))
    (broken,) = [check for check in validate(tmp_path / "data") if not check.ok]
    assert (broken.name, "disp_sgbm/000000.png" in broken.detail) == ("kitti images", True)


def test_the_readme_says_what_is_there(root: Path) -> None:
    text = (root / "kitti/README.md").read_text()
    assert "P0 and P2 are the left camera" in text
    assert "further LiDARs (rear)" in text


def test_disparities_are_256ths_and_too_large_ones_are_none(tmp_path: Path) -> None:
    path = tmp_path / "disparity.png"
    path.write_bytes(encode_disparity(np.array([[0.0, 1.0, 37.123, 255.99, 256.0, 900.0]], np.float32)))
    assert cv2.imread(str(path), cv2.IMREAD_UNCHANGED).tolist() == [[0, 256, 9503, 65533, 0, 0]]


def test_without_a_right_camera_all_four_are_the_same() -> None:
    matrices = read_matrices(calib_text(CAMERA, T_CAMERA_LIDAR), "calib", OUR_SHAPES)
    assert all(np.array_equal(matrices[f"P{number}"], matrices["P0"]) for number in range(4))
