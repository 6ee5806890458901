"""Datasets that hold clean images beside the readings."""

import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.toy import CAMERA, failures, make_dataset, make_manifest, make_scene, observe, with_recipe
from warehouse_sim.dataset.files.image_io import decode_depth, encode_clean_depth
from warehouse_sim.dataset.formats.kitti import KITTI_KINDS, kitti_kinds
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import Observation, StereoReading

WITH_CLEAN = {"sensors": {"outputs": ["default", "clean"], "right": {"baseline": 0.2, "matching": None}}}


def as_read(observation: Observation) -> Observation:
    """The exact observation with errors of its cameras: the ground truth stays in its buffers."""
    depth, rgb = observation.buffers.depth, observation.buffers.rgb
    read = np.where(depth < 20.0, depth * np.float32(1.001), np.float32(0.0))
    disparity = np.where(depth > 0, CAMERA.fx * 0.2 / np.maximum(depth, 0.1), 0.0).astype(np.float32)
    stereo = StereoReading(0.2, rgb // 3, observation.buffers, disparity, disparity > 1.0)
    reading = replace(observation.rgbd, rgb=rgb // 2, depth=read)
    return observation.with_reading("camera", reading).with_reading("right", stereo)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    manifest = with_recipe(make_manifest(), WITH_CLEAN)
    return make_dataset(tmp_path_factory.mktemp("clean") / "data", manifest, change=as_read)


def test_off_by_default() -> None:
    assert not recipe_contents({}).clean
    assert not recipe_contents({"sensors": {"camera": {}}}).clean
    assert kitti_kinds(recipe_contents({"sensors": {}})) == KITTI_KINDS
    clean = kitti_kinds(recipe_contents({"sensors": {"outputs": ["default", "clean"]}}))
    assert set(clean) - set(KITTI_KINDS) == {"image_clean_2", "depth_clean_2"}


def test_clean_images_are_read_back_beside_the_readings(made: Path) -> None:
    reader = DatasetReader(made)
    assert reader.has_clean
    for image in reader.images("train"):
        exact = observe(make_scene(image.scene_id))[image.image_id]
        assert np.array_equal(reader.clean_rgb(image), exact.buffers.rgb)
        assert np.abs(reader.clean_depth(image) - exact.buffers.depth).max() <= 0.5e-3 + 1e-6
        assert np.array_equal(reader.rgb(image), exact.buffers.rgb // 2)
        assert np.abs(reader.depth(image) - as_read(exact).rgbd.depth).max() <= 0.5e-3 + 1e-6


def test_kitti_holds_them_in_folders_of_their_own(made: Path) -> None:
    folder, exact = made / "kitti/training", observe(make_scene(0))[0]
    steps = decode_depth(folder / "depth_clean_2/000000.png")
    assert np.abs(steps / 256.0 - exact.buffers.depth).max() <= 0.5 / 256 + 1e-6
    for name in ("image_clean_2", "image_clean_3"):
        assert np.array_equal(cv2.imread(str(folder / name / "000000.png"))[..., ::-1], exact.buffers.rgb)
    bop = made / "bop/train/000000/rgb_clean/000000.png"
    assert (folder / "image_clean_2/000000.png").samefile(bop)
    for text in (made / "kitti/README.md", made / "bop/dataset_info.md"):
        assert "without errors of the camera" in text.read_text()


def test_they_pass_validation(made: Path) -> None:
    assert failures(made) == {}


@pytest.mark.parametrize("name", ["kitti/training/depth_clean_2/000000.png", "bop/train/000000/depth_clean/000000.png"])
def test_validation_notices_what_is_missing_or_of_another_place(made: Path, tmp_path: Path, name: str) -> None:
    root = Path(shutil.copytree(made, tmp_path / "copy"))
    steps = decode_depth(root / name)
    cv2.imwrite(str(root / name), 3 * steps)
    (broken,) = failures(root).values()
    assert "is not the ground truth behind the depth that was read" in broken
    (root / name).unlink()
    assert any("000000.png" in check.detail and "clean" in check.detail for check in validate(root) if not check.ok)


def test_validation_looks_at_the_clean_right_image(made: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made, tmp_path / "copy"))
    path = root / "kitti/training/image_clean_3/000000.png"
    negative = 255 - cv2.imread(str(path))
    path.unlink()  # It may share its bytes with others.
    cv2.imwrite(str(path), negative)
    (broken,) = failures(root).values()
    assert f"{path}: is not of what the image that was read shows" in broken
    path.write_bytes(b"")
    (broken,) = failures(root).values()
    assert str(path) in broken


def test_validation_notices_a_seen_disparity_that_is_not_the_true_one(made: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made, tmp_path / "copy"))
    path = root / "kitti/training/disp_noc/000000.png"
    steps = decode_depth(path)
    cv2.imwrite(str(path), np.where(steps > 0, steps + 1, 0).astype(np.uint16))
    (broken,) = failures(root).values()
    assert "is no part of disp_occ" in broken


def test_a_dataset_without_them_says_how_to_get_them(toy_root: Path) -> None:
    reader = DatasetReader(toy_root)
    assert not reader.has_clean
    with pytest.raises(DatasetError, match=r"--outputs default clean"):
        reader.clean_depth(reader.images("train")[0])


def test_a_clean_depth_that_does_not_fit_is_none(tmp_path: Path) -> None:
    path = tmp_path / "depth.png"
    path.write_bytes(encode_clean_depth(np.array([[0.0, 1.5, 65.535, 65.6, 300.0]], np.float32), 1000.0))
    assert decode_depth(path).tolist() == [[0, 1500, 65535, 0, 0]]
