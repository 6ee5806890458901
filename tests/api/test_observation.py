import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.shared import Shared
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.observation import Observation
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.geometry.pose import invert, transform_points

pytestmark = pytest.mark.gl


@pytest.fixture
def large(shared: Shared) -> Dataset:
    return Dataset(shared.dataset(scenes=3))


def test_arrays_are_numpy_in_metres(data: Dataset, smoke: Path) -> None:
    obs = data[3]
    folder = smoke / "bop/val/000001"
    rgb = cv2.imread(str(folder / "rgb/000001.png"))
    steps = cv2.imread(str(folder / "depth/000001.png"), cv2.IMREAD_UNCHANGED)
    scale = json.loads((folder / "scene_camera.json").read_text())["1"]["depth_scale"]
    assert obs.rgb.dtype == np.uint8
    assert obs.rgb.shape == (obs.camera.height, obs.camera.width, 3)
    assert np.array_equal(rgb[:, :, ::-1], obs.rgb)
    assert obs.depth.dtype == np.float32
    assert np.allclose(obs.depth, steps * (scale / 1000.0), atol=1e-6)
    assert 0.3 < np.median(obs.depth[obs.depth > 0]) < 20.0
    assert obs.rgb is obs.rgb  # read once


def test_points_are_the_depth_image_in_the_camera_frame(data: Dataset) -> None:
    obs = data[0]
    v, u = np.nonzero(obs.depth)
    assert obs.points.dtype == np.float32
    assert obs.points.shape == (len(u), 3)
    assert np.allclose(obs.points[:, 2], obs.depth[v, u])
    assert np.allclose(obs.camera.project(obs.points.astype(float)), np.column_stack([u, v]), atol=0.01)


def test_the_sweep_is_in_the_axes_of_the_lidar(data: Dataset) -> None:
    obs = data[0]
    assert obs.lidar is not None
    assert obs.lidar_intensity is not None
    assert obs.T_camera_lidar is not None
    assert obs.T_world_camera is not None
    assert obs.lidar.dtype == np.float32
    assert len(obs.lidar) == len(obs.lidar_intensity) > 10_000
    height = transform_points(obs.T_world_camera @ obs.T_camera_lidar, obs.lidar.astype(float))[:, 2]
    assert abs(np.percentile(height, 5)) < 0.1  # many points lie on the floor


def test_labels_lie_on_what_is_seen(large: Dataset) -> None:
    for obs in large:
        assert obs.objects
        for item in obs.objects:
            assert item.name == "epal1"
            assert item.class_name == "pallet"
            assert item.mask.dtype == np.bool_
            assert not (item.mask & ~item.amodal_mask).any()
            rows, columns = np.nonzero(item.mask)
            assert item.box_2d == (columns.min(), rows.min(), columns.max(), rows.max())
            if obs.T_world_camera is not None and item.visible_fraction == 1.0:
                assert item.mask.sum() == item.amodal_mask.sum()
            inside = transform_points(invert(item.T_camera_object), _points_of(obs, item.mask))
            near = np.all(np.abs(inside) < item.size / 2 + 0.1, axis=1)
            assert near.mean() > 0.9
            assert np.allclose(np.ptp(transform_points(invert(item.T_camera_object), item.box_3d), axis=0), item.size)


def _points_of(obs: Observation, mask: np.ndarray) -> np.ndarray:
    return obs.camera.unproject(obs.depth)[mask & (obs.depth > 0)]


def test_the_instance_mask_numbers_the_labelled_objects(data: Dataset) -> None:
    obs = data[2]
    assert obs.instance_mask.dtype == np.int32
    assert set(np.unique(obs.instance_mask)) == {0} | {item.instance_id for item in obs.objects}
    for item in obs.objects:
        assert np.array_equal(obs.instance_mask == item.instance_id, item.mask)


def test_it_draws_its_labels_and_shows_itself(large: Dataset, tmp_path: Path) -> None:
    obs = large[3]
    picture = obs.draw(tmp_path / "deep" / "look.png")
    stored = cv2.imread(str(tmp_path / "deep" / "look.png"))
    assert np.array_equal(stored[:, :, ::-1], picture)
    assert picture.shape == obs.rgb.shape
    changed = (picture != obs.rgb).any(axis=2)
    assert all(changed[item.mask].mean() > 0.9 for item in obs.objects)
    assert changed.mean() < 0.5
    assert obs._repr_png_().startswith(b"\x89PNG")
    assert repr(obs) == "<Observation scene 1, image 1 (val): 1224 x 370 px, 4 objects>"
    assert repr(obs.objects[0]).startswith("<epal1 18: 55% visible, 4.99 m away")


def test_drawing_says_what_it_cannot_write(data: Dataset, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'look.jpg' must end in .png"):
        data[0].draw("look.jpg")
    with pytest.raises(InputError, match="path must be text, a path or None, found 3"):
        data[0].draw(3)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="comes from a dataset"):
        Observation(1, 2)  # type: ignore[arg-type]


@pytest.fixture
def bare_coco(smoke: Path, tmp_path: Path) -> Dataset:
    """Return COCO alone, as somebody else's: images, boxes, masks."""
    shutil.copytree(smoke / "coco", tmp_path / "coco")
    return Dataset(tmp_path / "coco")


def test_a_damaged_file_is_said_in_one_line(smoke: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    shutil.copytree(smoke, tmp_path / "out")
    path = tmp_path / "out/bop/train/000000/rgb/000000.png"
    path.write_bytes(path.read_bytes()[:1000])
    data = Dataset(tmp_path / "out")
    with pytest.raises(DatasetError, match=r"000000.png: "):
        data[0].rgb  # noqa: B018
    assert data[0].draw().any()
    assert "the labels are drawn on the depth image" in caplog.text
    assert data[1].rgb.any()


def test_what_a_folder_lacks_is_said_in_one_line(bare_coco: Dataset) -> None:
    obs = bare_coco[0]
    assert obs.rgb.shape[2] == 3
    assert obs.lidar is None
    assert obs.objects[0].class_name == "pallet"
    assert obs.objects[0].mask.any()
    for read in (lambda: obs.depth, lambda: obs.points, lambda: obs.objects[0].size, lambda: obs.objects[0].box_3d):
        with pytest.raises(DatasetError) as caught:
            read()
        assert str(bare_coco.path) in str(caught.value)
        assert "such as bop" in str(caught.value) or "intrinsics" in str(caught.value)
    assert obs.draw().shape[2] == 3
