import cv2
import numpy as np

from warehouse_sim.dataset.viewing.overlay import colorize_depth, draw_segment
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion


def test_a_straight_edge_is_drawn_as_the_curve_that_the_lens_shows() -> None:
    camera = PinholeCamera(200, 120, 120.0, 120.0, 99.5, 59.5, Distortion(k1=-0.25, k2=0.05))
    ends = np.array([-0.55, -0.35, 1.0]), np.array([1.65, -1.05, 3.0])
    image = np.zeros((120, 200, 3), np.uint8)
    draw_segment(image, camera, *ends, (255, 255, 255))
    fraction = np.linspace(0.02, 0.98, 200)[:, None]
    on_edge = np.round(camera.project(ends[0] + fraction * (ends[1] - ends[0]))).astype(int)
    assert (image[on_edge[:, 1], on_edge[:, 0]].max(axis=-1) > 40).all()
    sampled = np.argwhere(image[..., 0] > 128).astype(np.float32)
    way_y, way_x, y, x = cv2.fitLine(sampled, cv2.DIST_L2, 0, 0.01, 0.01).ravel()
    assert np.abs(way_y * (sampled[:, 1] - x) - way_x * (sampled[:, 0] - y)).max() > 1.5


def test_depth_is_coloured_as_opencv_does_and_no_pixels_are_no_crash() -> None:
    depth = np.array([[0.0, 0.5, 1.0, 5.0, 20.0, 90.0]], np.float32)
    place = 1.0 - np.log(np.clip(depth, 0.5, 20.0) / 0.5) / np.log(40.0)
    expected = cv2.applyColorMap((255 * place).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1]
    np.testing.assert_array_equal(colorize_depth(depth)[0, 1:], expected[0, 1:])
    assert not colorize_depth(depth)[0, 0].any()
    assert colorize_depth(np.zeros((1, 0), np.float32)).shape == (1, 0, 3)  # OpenCV itself ends the process here
