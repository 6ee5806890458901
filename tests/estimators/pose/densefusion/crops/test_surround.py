import numpy as np

from tests.dataset.toy import CAMERA
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop, CropLabel, cut_mask, image_crops
from warehouse_sim.estimators.pose.densefusion.crops.surround import OUTLINE_SIDE
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig

CONFIG = CropConfig(surround_px=5, stored_points=4096)
SHAPE = CAMERA.height, CAMERA.width
DEPTH = np.full(SHAPE, 2.0, dtype=np.float32)


def block(left: int, top: int, right: int, bottom: int) -> np.ndarray:
    mask = np.zeros(SHAPE, dtype=bool)
    mask[top : bottom + 1, left : right + 1] = True
    return mask


def cut(mask: np.ndarray, owners: np.ndarray | None = None, config: CropConfig = CONFIG) -> Crop:
    label = CropLabel(0, 0, 0, 1, np.eye(4))
    crop = cut_mask(CAMERA, label, mask, DEPTH, None, config, np.random.default_rng(0), owners)
    assert crop is not None
    return crop


def pixels(crop: Crop) -> np.ndarray:
    return CAMERA.project(crop.points.astype(float)).round().astype(int)


def test_a_crop_holds_the_rim_about_the_box_and_says_what_the_mask_holds() -> None:
    mask = block(40, 30, 79, 49)
    mask[30:40, 60:80] = False
    crop = cut(mask)
    found = {tuple(pixel) for pixel in pixels(crop)}
    assert found == {(u, v) for u in range(35, 85) for v in range(25, 55)}
    u, v = pixels(crop).T
    np.testing.assert_array_equal(crop.around.signed_px > 0, mask[v, u])
    np.testing.assert_array_equal(crop.around.belongs, mask[v, u])
    np.testing.assert_array_equal(crop.around.uv - crop.around.uv[0], pixels(crop) - pixels(crop)[0])


def test_distances_to_the_outline_are_those_of_a_slow_count() -> None:
    mask = block(40, 30, 79, 49)
    mask[34:38, 50:60] = False
    crop = cut(mask)
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
    crop = cut(block(38, 28, 71, 51), owners)
    u, v = pixels(crop).T
    np.testing.assert_array_equal(crop.around.belongs, owners[v, u] == 1)
    np.testing.assert_array_equal(crop.around.neighbour > 0, owners[v, u] == 2)
    # The touching one lies in the crop as far as the window does: half a side.
    assert u[crop.around.neighbour > 0].max() > 71 + 5
    assert (owners[v, u] != 3).all()


def test_the_map_of_distances_is_that_of_the_points() -> None:
    mask = block(40, 30, 99, 69)
    around = cut(mask).around
    assert around.outline.shape == (OUTLINE_SIDE, OUTLINE_SIDE)
    cells = ((around.uv + 0.5) * OUTLINE_SIDE / around.window_px).astype(int)
    found = around.outline[cells[:, 1], cells[:, 0]].astype(float)
    # A cell is a pixel and a half here.
    assert np.abs(found - around.signed_px).max() <= 1.0 + around.window_px / OUTLINE_SIDE


def test_a_small_part_of_a_large_box_keeps_its_points() -> None:
    mask = block(0, 0, 4, 19) | block(150, 90, 153, 91)
    crop = cut(mask, config=CropConfig(surround_px=4, stored_points=300))
    assert len(crop.points) == 300
    assert (crop.around.signed_px > 0).sum() >= 100


def test_crops_of_a_dataset_know_gravity_and_the_ground_truth(toy_root) -> None:
    reader = DatasetReader(toy_root)
    image = next(item for item in reader.images("train") if item.targets)
    for crop in image_crops(reader, image, CONFIG, 0):
        np.testing.assert_allclose(crop.down, -image.T_world_camera[2, :3])
        u, v = pixels(crop).T
        np.testing.assert_array_equal(crop.around.belongs, reader.mask_visible(image, crop.position)[v, u])
