"""A pair behind lenses: what rays say that both see, and what matching finds once the images are straight."""

import cv2
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.sensors.stereo import SgbmConfig, both_see, gt_disparity, match, match_sgbm

CAMERA = PinholeCamera(320, 200, 240.0, 240.0, 158.2, 101.7, Distortion(k1=-0.3, k2=0.1, p1=0.002))
BASELINE, NEAR, FAR = 0.2, 2.0, 6.0


def board_depth(eye: float) -> np.ndarray:
    """Depth of a board of 0.8 x 0.8 m before a wall, from a camera that stands ``eye`` to the right (m)."""
    x, y, _ = np.moveaxis(CAMERA.rays() * NEAR, -1, 0)
    return np.where((np.abs(x + eye) < 0.4) & (np.abs(y) < 0.4), NEAR, FAR).astype(np.float32)


def test_both_see_what_is_neither_hidden_nor_outside() -> None:
    left, right = (gt_disparity(board_depth(eye), CAMERA.fx, BASELINE) for eye in (0.0, BASELINE))
    found = both_see(left, right, CAMERA)
    points = CAMERA.rays() * board_depth(0.0)[..., None].astype(float)
    crossing = points + (np.array([BASELINE, 0.0, 0.0]) - points) * ((points[..., 2:] - NEAR) / points[..., 2:])
    hidden = (points[..., 2] > NEAR + 1) & (np.abs(crossing[..., :2]) < 0.4).all(axis=-1)
    uv = CAMERA.project(points - [BASELINE, 0.0, 0.0])
    inside = ((uv > -0.5) & (uv < [CAMERA.width - 0.5, CAMERA.height - 0.5])).all(axis=-1)
    expected = inside & ~hidden
    assert 0.02 < hidden.mean() < 0.2
    assert (found == expected).mean() > 0.985


def test_matching_needs_straight_rows_and_gets_them() -> None:
    """A textured wall, 3 m away and turned, seen by both cameras: its true disparity is found behind the lens, too."""
    noise = np.random.default_rng(5).integers(0, 256, (700, 1000, 3)).astype(np.float32)
    paint = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 2.0), None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)

    def seen_from(eye: float) -> tuple[np.ndarray, np.ndarray]:
        x, y, _ = np.moveaxis(CAMERA.rays(), -1, 0)
        depth = (3.0 - 0.4 * eye) / (1.0 + 0.4 * x)  # z = 3 - 0.4 X in the left camera's frame
        place = [(500 + 130 * (x * depth + eye)).astype(np.float32), (350 + 130 * y * depth).astype(np.float32)]
        return cv2.remap(paint, *place, cv2.INTER_LINEAR), depth.astype(np.float32)

    (left, depth), (right, _) = seen_from(0.0), seen_from(BASELINE)
    true = gt_disparity(depth, CAMERA.fx, BASELINE)
    found = match(left, right, SgbmConfig(disparities=64), CAMERA)
    known = found > 0
    assert known.mean() > 0.8
    assert np.median(np.abs(found - true)[known]) < 0.2
    crooked = match_sgbm(left, right, SgbmConfig(disparities=64))
    corners = np.hypot(*np.moveaxis(CAMERA.rays()[..., :2], -1, 0)) > 0.6
    wrong = np.median(np.abs(crooked - true)[corners & (crooked > 0)])
    assert np.median(np.abs(found - true)[corners & known]) < 0.3 * wrong
