import numpy as np
import pytest

from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.estimators.images.rows import canonical_mm
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera

SIZES = [(1224, 370), (848, 480), (640, 480), (480, 640), (100, 37)]


@pytest.mark.parametrize("source_wh", SIZES)
def test_the_area_is_that_of_the_input_and_the_shape_that_of_the_image(source_wh: tuple[int, int]) -> None:
    box = Letterbox.fit(source_wh, (640, 192))
    width, height = box.size_wh
    assert width % 32 == height % 32 == 0
    assert 0.75 < width * height / (640 * 192) < 1.3
    assert box.scale_xy[0] == pytest.approx(box.scale_xy[1], rel=0.01)
    assert box.inner_wh[0] == width or box.inner_wh[1] == height


def test_the_kitti_image_gets_the_canvas_that_the_input_names() -> None:
    assert Letterbox.fit((1224, 370), (640, 192)).size_wh == (640, 192)


@pytest.mark.parametrize("source_wh", SIZES[:4])
def test_boxes_go_where_their_pixels_go(source_wh: tuple[int, int]) -> None:
    box = Letterbox.fit(source_wh, (320, 160))
    image = np.zeros((source_wh[1], source_wh[0]), dtype=np.float32)
    image[100:180, 60:240] = 3.0
    edges = np.array([[60.0, 100.0, 240.0, 180.0]])
    left, top, right, bottom = mask_box_xyxy(box.picked(image) > 0)
    found = np.array([left, top, right + 1, bottom + 1])
    np.testing.assert_allclose(found, box.onto_canvas(edges)[0], atol=0.75)
    np.testing.assert_allclose(box.off_canvas(box.onto_canvas(edges)), edges)
    colours = box.smooth(np.repeat((image > 0)[..., None], 3, axis=2).astype(np.uint8) * 255, fill=0)
    left, top, right, bottom = mask_box_xyxy(colours[..., 0] > 127)
    np.testing.assert_allclose([left, top, right + 1, bottom + 1], box.onto_canvas(edges)[0], atol=0.75)


def test_depths_are_picked_and_never_mixed() -> None:
    depth = np.where(np.indices((370, 1224)).sum(axis=0) % 2, 2.0, 8.0).astype(np.float32)
    assert set(np.unique(Letterbox.fit((1224, 370), (640, 192)).picked(depth))) <= {0.0, 2.0, 8.0}


def test_canonical_depth_is_that_of_the_same_size_in_pixels() -> None:
    """A camera of half the focal length sees an object at half the distance as large."""
    near, far = canonical_mm(np.array([[2.5]]), 200.0), canonical_mm(np.array([[5.0]]), 400.0)
    assert near.item() == far.item() == 5000
    assert canonical_mm(np.array([[500.0]]), 400.0).item() == 65_000


def test_the_focal_length_scales_with_the_image() -> None:
    camera = PinholeCamera.from_focal(1224, 370, 721.5377)
    assert Letterbox.fit((1224, 370), (640, 192)).focal_px(camera) == pytest.approx(721.5377 * 0.519, rel=0.002)
