import numpy as np
import pytest
import torch
from torch.nn import functional

from tests.dataset.toy import PALLET
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.segmenters.segnet.keypoints import (
    MIRRORED,
    face_points,
    find_peaks,
    pocket_faces,
    side_points,
)
from warehouse_sim.estimators.segmenters.segnet.network import SegNet, _unpooled, relative
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig
from warehouse_sim.estimators.segmenters.segnet.task import keypoint_loss, kind_loss, mask_loss
from warehouse_sim.estimators.segmenters.segnet.window import Window
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z


def test_unpooling_is_that_of_torch() -> None:
    x = torch.randn(2, 5, 16, 32)
    pooled, place = functional.max_pool2d(x, 2, return_indices=True)
    assert torch.equal(_unpooled(pooled, place), functional.max_unpool2d(pooled, place, 2))


def test_maps_have_the_size_of_the_input() -> None:
    assert SegNet(4, 7, 8).eval()(torch.zeros(2, 4, 48, 96)).shape == (2, 7, 48, 96)
    with pytest.raises(ConfigError, match="multiples of 16"):
        BoxCropConfig(crop_wh=(90, 48))


def test_depth_is_relative_to_the_median_of_what_is_valid_in_the_middle() -> None:
    rng = np.random.default_rng(0)
    depth = np.where(rng.random((3, 48, 96)) < 0.6, rng.uniform(2, 4, (3, 48, 96)), 0.0).astype(np.float32)
    depth[2] = 0.0
    found = relative(torch.from_numpy(depth), torch.tensor([0.2, 0.3, 0.4])).numpy()
    for i in range(2):
        middle = depth[i, 12:36, 19:77]
        median = np.sort(middle[middle > 0])[(middle > 0).sum() // 2]
        offset = np.where(depth[i] > 0, depth[i] - median, 0.0)
        np.testing.assert_allclose(found[i, 0], np.clip(offset / 0.25, -1, 1), atol=1e-5)
        np.testing.assert_allclose(found[i, 1], np.clip(offset / 1.5, -1, 1), atol=1e-5)
        np.testing.assert_allclose(found[i, 3], np.log([0.2, 0.3][i] * median), atol=1e-5)
        np.testing.assert_array_equal(found[i, 2], depth[i] > 0)
    assert np.isfinite(found).all()
    assert (found[2, :3] == 0).all()


def test_the_right_mask_costs_nothing_and_the_opposite_much() -> None:
    gt = (torch.rand(3, 16, 32) < 0.4).float()
    assert mask_loss(40 * gt - 20, gt) < 1e-3
    assert mask_loss(20 - 40 * gt, gt) > 10


def test_each_kind_of_a_batch_counts_the_same_and_strangers_do_not() -> None:
    logits = torch.tensor([[2.0, 0.0], [2.0, 0.0], [2.0, 0.0], [0.0, 1.0], [9.0, -9.0]])
    loss = kind_loss(logits, torch.tensor([0, 0, 0, 1, -1]))
    expected = (np.log1p(np.exp(-2.0)) + np.log1p(np.exp(-1.0))) / 2.0
    np.testing.assert_allclose(loss, expected, rtol=1e-6)
    assert kind_loss(logits, torch.full((5,), -1)) == 0.0


def test_descent_on_maps_puts_points_where_they_are() -> None:
    points = torch.tensor([[[10.3, 7.8, 1.0], [50.0, 20.0, 1.0], [5.0, 5.0, 0.0]]])
    maps = torch.nn.Parameter(torch.zeros(1, 3, 32, 64))
    optimiser = torch.optim.Adam([maps], lr=0.3)
    for _ in range(120):
        optimiser.zero_grad()
        keypoint_loss(maps, points).backward()
        optimiser.step()
    found = find_peaks(maps.detach())
    np.testing.assert_allclose(found.uv[0, :2], points[0, :2, :2], atol=0.15)
    assert (found.chance[0, :2] > 0.8).all()
    assert found.chance[0, 2] < 0.1


def test_points_of_a_side_are_named_as_one_sees_them_who_stands_before_it() -> None:
    """Seen from -y, right is +x: corners and pockets by hand."""
    pallet = PALLET
    points, known = side_points(pallet.size, pallet.pockets, "-y")
    length, width, height = pallet.size
    np.testing.assert_allclose(points[0], [-length / 2, -width / 2, height / 2])
    np.testing.assert_allclose(points[2], [length / 2, -width / 2, -height / 2])
    # The toy pallet has one pocket a side: no two centres to tell.
    assert known.tolist() == [True] * 4 + [False] * 2
    assert pocket_faces(pallet.pockets) == ["+y", "-y"]


def test_the_side_that_is_seen_is_taken_and_left_is_left_in_the_image() -> None:
    for yaw in np.linspace(-2.8, 2.8, 9):
        T_world_camera = level_camera(np.array([0.0, -4.0, 1.0]), np.pi / 2)
        T_camera_object = np.linalg.inv(T_world_camera) @ make_transform(rotation_z(yaw), np.array([0.2, 0.0, 0.1]))
        face = face_points(PALLET.size, PALLET.pockets, T_camera_object)
        assert face is not None
        points, _ = face
        u, v = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
        assert u[0] < u[1]
        assert u[3] < u[2]
        assert v[0] < v[3]
        assert points[:4, 2].mean() < T_camera_object[2, 3]


def test_the_mirror_of_the_mirror_is_the_point_itself() -> None:
    assert [MIRRORED[MIRRORED[i]] for i in range(6)] == list(range(6))


BOX = (40.0, 30.0, 140.0, 54.0)


def painted() -> np.ndarray:
    image = np.zeros((120, 200), dtype=np.float32)
    image[30:54, 40:140] = 1.0
    return image


def test_a_box_fills_the_crop_but_for_the_margin() -> None:
    window = Window.about(BOX, 0.25, (96, 48))
    left, top, right, bottom = mask_box_xyxy(window.picked(painted()) > 0.5)
    np.testing.assert_allclose([left, top, right + 1, bottom + 1], [16, 8, 80, 40], atol=0.6)


@pytest.mark.parametrize("mirrored", [False, True])
def test_points_go_where_pixels_go(mirrored: bool) -> None:
    window = Window.about((10.0, 5.0, 60.0, 30.0), 0.1, (100, 60))
    for u, v in ((12, 7), (40, 20), (58, 28)):
        image = np.zeros((60, 90), dtype=np.uint8)
        image[v, u] = 1
        rows, columns = np.nonzero(window.picked(image, mirrored))
        place = window.to_crop(np.array([[float(u), float(v)]]), mirrored)[0]
        np.testing.assert_allclose([columns.mean(), rows.mean()], place, atol=0.6)
        if not mirrored:
            np.testing.assert_allclose(window.to_image(place[None])[0], [u, v], atol=1e-9)


def test_what_was_cut_comes_back_in_its_place() -> None:
    window = Window.about(BOX, 0.15, (192, 96))
    back = window.pasted(window.picked(painted()), (200, 120))
    assert (np.abs(back - painted()) > 0.5).mean() < 1e-3
    assert back[0, 0] == 0.0


def test_a_window_beyond_the_image_is_empty_there() -> None:
    crop = Window.about((-50.0, 30.0, 50.0, 54.0), 0.0, (96, 48)).picked(np.ones((120, 200), dtype=np.float32))
    assert (crop[:, :47] == 0).all()
    assert (crop[:, 49:] == 1).all()


def test_many_pixels_are_averaged_into_one() -> None:
    board = (np.indices((120, 200)).sum(axis=0) % 2 * 255).astype(np.uint8)
    crop = Window((0.0, 0.0, 200.0, 120.0), (25, 15)).smooth(np.repeat(board[..., None], 3, axis=2))
    assert np.abs(crop.astype(int) - 127).max() < 20
