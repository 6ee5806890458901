import numpy as np
import pytest

from warehouse_sim.annotate.occluders import Window, box_in_image, window_in_image


def test_a_mask_inside_the_image_is_whole() -> None:
    assert window_in_image((3, 2), (4, 5), (10, 20)) == Window((slice(2, 6), slice(3, 8)), (slice(0, 4), slice(0, 5)))


@pytest.mark.parametrize("offset", [(-2, -3), (17, 8), (-2, 8), (17, -3)])
def test_a_mask_over_a_corner_is_cut_like_a_padded_canvas(offset: tuple[int, int]) -> None:
    mask = np.random.default_rng(0).random((4, 5)) < 0.5
    canvas = np.zeros((30, 60), bool)
    canvas[10 + offset[1] : 14 + offset[1], 20 + offset[0] : 25 + offset[0]] = mask
    window = window_in_image(offset, (4, 5), (10, 20))
    assert window is not None
    image = np.zeros((10, 20), bool)
    image[window.image] = mask[window.mask]
    assert np.array_equal(image, canvas[10:20, 20:40])


@pytest.mark.parametrize("offset", [(-5, 0), (20, 0), (0, -4), (0, 10)])
def test_a_mask_beside_the_image_has_no_window(offset: tuple[int, int]) -> None:
    assert window_in_image(offset, (4, 5), (10, 20)) is None


def test_the_box_is_inclusive_and_in_image_coordinates() -> None:
    window = Window((slice(2, 6), slice(3, 8)), (slice(0, 4), slice(0, 5)))
    mask = np.zeros((4, 5), bool)
    assert box_in_image(mask, window) is None
    mask[1, 2] = mask[3, 4] = True
    assert box_in_image(mask, window) == (5, 3, 7, 5)
