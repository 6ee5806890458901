from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.toy import CAMERA
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.pose.densefusion.crops.cut import (
    Crop,
    CropLabel,
    back_project,
    cut_mask,
    image_crops,
    label_of,
)
from warehouse_sim.estimators.pose.densefusion.crops.surround import OUTLINE_SIDE, Window
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import invert, make_transform, transform_points


def target(pixels: int = 500, fraction: float = 1.0) -> TargetRecord:
    return TargetRecord(
        0, 1, 0, make_transform(None, np.array([0.0, 0, 3])), fraction, pixels, (0,) * 4, (0,) * 4, 0, 0
    )


def image(*targets: TargetRecord) -> ImageRecord:
    return ImageRecord("train", 0, 0, CAMERA, np.eye(4), 1.0, targets)


def block_mask(left: int, top: int, right: int, bottom: int) -> np.ndarray:
    mask = np.zeros((CAMERA.height, CAMERA.width), dtype=bool)
    mask[top : bottom + 1, left : right + 1] = True
    return mask


def cut(mask: np.ndarray, depth: np.ndarray, config: CropConfig, rgb: np.ndarray | None = None):
    return cut_mask(image().camera, label_of(image(), target()), mask, depth, rgb, config, np.random.default_rng(0))


def test_back_projection_inverts_the_projection_at_integer_pixel_centres() -> None:
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width].reshape(2, -1)
    depth = np.linspace(0.5, 9.0, u.size).astype(np.float32)
    points = back_project(CAMERA, u, v, depth)
    np.testing.assert_allclose(CAMERA.project(points.astype(float)), np.stack([u, v], axis=-1), atol=2e-5)
    np.testing.assert_array_equal(points[:, 2], depth)


def test_crop_holds_exactly_the_pixels_of_the_mask_with_a_reading() -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 2.0, dtype=np.float32)
    depth[20, 30:35] = 0.0
    crop = cut(block_mask(30, 20, 59, 39), depth, CropConfig())
    uv = CAMERA.project(crop.points.astype(float)).round().astype(int)
    expected = {(u, v) for u in range(30, 60) for v in range(20, 40)} - {(u, 20) for u in range(30, 35)}
    assert {tuple(pixel) for pixel in uv} == expected
    assert len(uv) == len(expected)


def test_border_distance_counts_rings_from_the_edge_of_the_mask() -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 2.0, dtype=np.float32)
    crop = cut(block_mask(30, 20, 59, 39), depth, CropConfig())
    u, v = CAMERA.project(crop.points.astype(float)).round().astype(int).T
    rings = 1 + np.minimum.reduce([u - 30, 59 - u, v - 20, 39 - v])
    np.testing.assert_array_equal(crop.border_px, rings)


def test_large_targets_are_thinned_and_small_ones_left_out() -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 2.0, dtype=np.float32)
    assert len(cut(block_mask(0, 0, 99, 79), depth, CropConfig(stored_points=128)).points) == 128
    assert cut(block_mask(0, 0, CropConfig.min_points - 2, 0), depth, CropConfig()) is None
    assert cut(np.zeros_like(depth, dtype=bool), depth, CropConfig()) is None


@pytest.mark.parametrize("box", [(30, 20, 59, 39), (0, 0, 20, 50), (140, 80, 159, 95)])
def test_each_point_finds_its_own_colour_in_the_crop(box: tuple[int, int, int, int]) -> None:
    # Colours change slowly, so that resampling shifts them by less than one pixel's difference.
    columns, rows = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    rgb = np.stack([columns, rows, columns // 2], axis=-1).astype(np.uint8)
    depth = np.full(columns.shape, 3.0, dtype=np.float32)
    crop = cut(block_mask(*box), depth, CropConfig(side_px=48), rgb)
    u, v = CAMERA.project(crop.points.astype(float)).round().astype(int).T
    found = crop.rgb.reshape(-1, 3)[crop.pixel].astype(int)
    scale = Window.around(box, 0.1).side / 48
    # The outermost crop pixels of a target at the image border blend with the black beyond.
    inside = (u > 2) & (v > 2) & (u < CAMERA.width - 3) & (v < CAMERA.height - 3)
    assert np.abs(found[inside, 0] - u[inside]).max() <= 1 + scale
    assert np.abs(found[inside, 1] - v[inside]).max() <= 1 + scale


def test_crops_of_a_stored_image_lie_on_the_cad_surface(toy_root) -> None:
    reader = DatasetReader(toy_root)
    crops = [crop for item in reader.images("train") for crop in image_crops(reader, item, CropConfig(), 0)]
    assert len(crops) >= 3
    for crop in crops:
        in_object = transform_points(invert(crop.T_camera_object), crop.points.astype(float))
        half = reader.objects[crop.obj_id].size / 2
        # Depth is stored in millimetres.
        assert (np.abs(in_object) <= half + 1.5e-3).all()
        on_face = np.abs(np.abs(in_object) - half).min(axis=1)
        assert np.median(on_face) < 1.5e-3


def test_the_same_pixels_are_kept_whatever_the_order_of_images(toy_root) -> None:
    reader = DatasetReader(toy_root)
    images = [item for item in reader.images("train") if item.targets]
    config = CropConfig(stored_points=64)
    first = [crop.points for item in images for crop in image_crops(reader, item, config, 5)]
    again = [crop.points for item in reversed(images) for crop in reversed(list(image_crops(reader, item, config, 5)))]
    for a, b in zip(first, reversed(again), strict=True):
        np.testing.assert_array_equal(a, b)


def test_depth_crop_holds_readings_of_the_image_never_averages() -> None:
    rng = np.random.default_rng(0)
    depth = rng.choice(np.array([0.0, 1.5, 4.0], dtype=np.float32), (CAMERA.height, CAMERA.width))
    mask = block_mask(100, 60, 159, 95)
    crop = cut(mask, depth, CropConfig(side_px=48, rgb=False, depth=True))
    assert crop.rgb is None
    assert set(np.unique(crop.depth)) == {np.float32(0), np.float32(1.5), np.float32(4)}
    window = Window.around((100, 60, 159, 95), 0.1)
    for row, column in ((0, 0), (20, 20), (24, 3), (40, 47)):
        u = window.left + int((column + 0.5) * window.side / 48)
        v = window.top + int((row + 0.5) * window.side / 48)
        inside = 0 <= u < CAMERA.width and 0 <= v < CAMERA.height
        assert crop.depth[row, column] == (depth[v, u] if inside else 0.0)


@pytest.mark.parametrize("box", [(30, 20, 59, 39), (0, 0, 20, 50), (2, 2, 158, 94)])
def test_ray_map_is_the_crop_cameras_and_meets_the_points(box: tuple[int, int, int, int]) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 3.0, dtype=np.float32)
    crop = cut(block_mask(*box), depth, CropConfig(side_px=48, rgb=False, depth=True))
    window = Window.around(box, 0.1)
    expected = np.linalg.inv(CAMERA.crop(window.left, window.top, 48, 48, 48 / window.side).K)[:2]
    np.testing.assert_allclose(crop.ray_map, expected, atol=1e-9)
    rays = crop.ray_map @ np.stack([crop.pixel % 48, crop.pixel // 48, np.ones(len(crop.pixel))])
    off = np.abs(rays.T - crop.points[:, :2] / 3.0) * [CAMERA.fx, CAMERA.fy]
    # A crop pixel covers a point's pixel if their centres are within half of either.
    assert off.max() <= 0.5 * max(1.0, window.side / 48) + 0.5


def test_a_lens_bends_points_and_rays_alike() -> None:
    camera = replace(CAMERA, distortion=Distortion(-0.2, 0.05, 0.001, -0.001))
    box = (100, 50, 155, 90)
    view = replace(image(), camera=camera)
    depth = np.full((camera.height, camera.width), 2.5, dtype=np.float32)
    config = CropConfig(side_px=64, rgb=False, depth=True, stored_points=4096)
    crop = cut_mask(
        view.camera, label_of(view, target()), block_mask(*box), depth, None, config, np.random.default_rng(0)
    )
    uv = camera.project(crop.points.astype(float))
    assert {tuple(pixel) for pixel in uv.round().astype(int)} == {
        (u, v) for u in range(100, 156) for v in range(50, 91)
    }
    np.testing.assert_allclose(uv, uv.round(), atol=1e-3)
    rays = crop.ray_map @ np.stack([crop.pixel % 64, crop.pixel // 64, np.ones(len(crop.pixel))])
    exact = crop.points[:, :2] / 2.5
    off = np.abs(rays.T - exact) * camera.fx
    straight = np.abs((uv - [camera.cx, camera.cy]) / [camera.fx, camera.fy] - exact) * camera.fx
    # In pixels: a straight map follows the bent rays on the whole, at the window's corners less. Half a pixel comes
    # from resampling.
    assert straight.max() > 6.0
    assert off.mean() < 1.2
    assert off.max() < 3.0


def test_a_square_crop_of_nothing_is_rejected() -> None:
    with pytest.raises(ConfigError, match="must hold rgb or depth"):
        CropConfig(side_px=48, rgb=False)


CONFIG = CropConfig(surround_px=5, stored_points=4096)
SHAPE = CAMERA.height, CAMERA.width
DEPTH = np.full(SHAPE, 2.0, dtype=np.float32)


def block(left: int, top: int, right: int, bottom: int) -> np.ndarray:
    mask = np.zeros(SHAPE, dtype=bool)
    mask[top : bottom + 1, left : right + 1] = True
    return mask


def cut_around(mask: np.ndarray, owners: np.ndarray | None = None, config: CropConfig = CONFIG) -> Crop:
    label = CropLabel(0, 0, 0, 1, np.eye(4))
    crop = cut_mask(CAMERA, label, mask, DEPTH, None, config, np.random.default_rng(0), owners)
    assert crop is not None
    return crop


def pixels(crop: Crop) -> np.ndarray:
    return CAMERA.project(crop.points.astype(float)).round().astype(int)


def test_a_crop_holds_the_rim_about_the_box_and_says_what_the_mask_holds() -> None:
    mask = block(40, 30, 79, 49)
    mask[30:40, 60:80] = False
    crop = cut_around(mask)
    found = {tuple(pixel) for pixel in pixels(crop)}
    assert found == {(u, v) for u in range(35, 85) for v in range(25, 55)}
    u, v = pixels(crop).T
    np.testing.assert_array_equal(crop.around.signed_px > 0, mask[v, u])
    np.testing.assert_array_equal(crop.around.belongs, mask[v, u])
    np.testing.assert_array_equal(crop.around.uv - crop.around.uv[0], pixels(crop) - pixels(crop)[0])


def test_distances_to_the_outline_are_those_of_a_slow_count() -> None:
    mask = block(40, 30, 79, 49)
    mask[34:38, 50:60] = False
    crop = cut_around(mask)
    rows, columns = np.nonzero(mask)
    others = np.argwhere(~mask)
    for (u, v), signed in list(zip(pixels(crop), crop.around.signed_px, strict=True))[:200]:
        near, far = np.hypot(*(others - [v, u]).T).min(), np.hypot(rows - v, columns - u).min()
        expected = near if mask[v, u] else -far
        # A chamfer distance of 5 x 5 pixels is off by a few per cent, and whole pixels are kept.
        assert abs(signed - expected) <= 0.5 + 0.05 * abs(expected)


def test_ground_truth_is_what_the_pixels_show_whatever_the_mask_says() -> None:
    owners = np.zeros(SHAPE, dtype=np.int32)
    owners[block(40, 30, 69, 49)] = 1
    owners[block(72, 30, 90, 49)] = 2
    owners[block(40, 75, 69, 79)] = 3
    crop = cut_around(block(38, 28, 71, 51), owners)
    u, v = pixels(crop).T
    np.testing.assert_array_equal(crop.around.belongs, owners[v, u] == 1)
    np.testing.assert_array_equal(crop.around.neighbour > 0, owners[v, u] == 2)
    # The touching one lies in the crop as far as the window does: half a side.
    assert u[crop.around.neighbour > 0].max() > 71 + 5
    assert (owners[v, u] != 3).all()


def test_the_map_of_distances_is_that_of_the_points() -> None:
    mask = block(40, 30, 99, 69)
    around = cut_around(mask).around
    assert around.outline.shape == (OUTLINE_SIDE, OUTLINE_SIDE)
    cells = ((around.uv + 0.5) * OUTLINE_SIDE / around.window_px).astype(int)
    found = around.outline[cells[:, 1], cells[:, 0]].astype(float)
    # A cell is a pixel and a half here.
    assert np.abs(found - around.signed_px).max() <= 1.0 + around.window_px / OUTLINE_SIDE


def test_a_small_part_of_a_large_box_keeps_its_points() -> None:
    mask = block(0, 0, 4, 19) | block(150, 90, 153, 91)
    crop = cut_around(mask, config=CropConfig(surround_px=4, stored_points=300))
    assert len(crop.points) == 300
    assert (crop.around.signed_px > 0).sum() >= 100


def test_crops_of_a_dataset_know_gravity_and_the_ground_truth(toy_root) -> None:
    reader = DatasetReader(toy_root)
    image = next(item for item in reader.images("train") if item.targets)
    for crop in image_crops(reader, image, CONFIG, 0):
        np.testing.assert_allclose(crop.down, -image.T_world_camera[2, :3])
        u, v = pixels(crop).T
        np.testing.assert_array_equal(crop.around.belongs, reader.mask_visible(image, crop.position)[v, u])
