import numpy as np
import pytest

from warehouse_sim.estimators.segmenters.segnet.window import Window
from warehouse_sim.geometry.boxes import mask_box_xyxy

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
