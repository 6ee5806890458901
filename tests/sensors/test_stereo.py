"""The second camera of a pair, its disparities, and the two behind lenses."""

import cv2
import numpy as np
import pytest

from tests.sensors.targets import plane
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.stereo import (
    SgbmConfig,
    StereoConfig,
    both_see,
    gt_disparity,
    match,
    match_sgbm,
    read_stereo,
    seen_in_both,
)
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(320, 120, 400.0)


def textured(shift: float) -> np.ndarray:
    """An image of blurred noise, its content moved to the left by ``shift`` (px)."""
    noise = np.random.default_rng(5).integers(0, 256, (120, 400, 3)).astype(np.float32)
    smooth = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 1.2), None, 0, 255, cv2.NORM_MINMAX)
    move = np.float32([[1, 0, -shift], [0, 1, 0]])
    return cv2.warpAffine(smooth, move, (400, 120), flags=cv2.INTER_CUBIC)[:, :320].clip(0, 255).astype(np.uint8)


def test_disparity_is_focal_length_times_baseline_over_depth() -> None:
    depth = np.array([[0.0, 2.0, 8.0]], np.float32)
    np.testing.assert_allclose(gt_disparity(depth, 720.0, 0.5), [[0.0, 180.0, 45.0]])


def test_what_a_nearer_thing_hides_or_the_right_image_ends_before_is_not_in_both() -> None:
    config = StereoConfig(baseline=0.3)
    near, far = 2.0, 6.0  # disparities of 60 and 20 px

    def seen_from(eye: float) -> np.ndarray:
        depth = np.full((CAMERA.height, CAMERA.width), far, np.float32)
        left, right = (round(CAMERA.cx + CAMERA.fx * (x - eye) / near) for x in (-0.1, 0.3))
        depth[:, left : right + 1] = near
        return gt_disparity(depth, CAMERA.fx, config.baseline)

    left, right = seen_from(0.0), seen_from(config.baseline)
    both = seen_in_both(left, right)
    assert (both == both[0]).all()
    hidden = np.flatnonzero(~both[0] & (np.arange(CAMERA.width) >= 20))
    edge = np.flatnonzero(left[0] > 30)[0]
    # f b (1 / z_near - 1 / z_far) = 40 columns of the far wall, directly to the left of the near thing.
    assert np.array_equal(hidden, np.arange(edge - 40, edge))
    assert not both[:, :20].any()
    assert not seen_in_both(np.zeros_like(left), right).any()


@pytest.mark.parametrize("shift", [4.0, 17.5, 40.0])
def test_matching_finds_the_shift_of_a_textured_wall(shift: float) -> None:
    found = match_sgbm(textured(0.0), textured(shift), SgbmConfig(disparities=64))
    known = found > 0
    # What lies left of the shift is not in the right image.
    assert not known[:, : int(shift) - 3].any()
    assert known[:, int(shift) + 8 : 300].mean() > 0.95
    assert np.abs(found[known] - shift).mean() < 0.25


def test_a_wall_without_texture_is_not_matched() -> None:
    grey = np.full((120, 320, 3), 128, np.uint8)
    assert (match_sgbm(grey, grey, SgbmConfig(disparities=64)) > 0).mean() < 0.05


def test_noise_of_the_right_image_is_its_own() -> None:
    left, config = plane(4.0, camera=CAMERA), StereoConfig(baseline=0.2, matching=SgbmConfig(disparities=64))
    right = RenderBuffers(textured(20.0), left.depth, left.instance_mask)

    def read(seed: int):
        rng = np.random.default_rng(seed)
        return read_stereo(left, textured(0.0), right, Capture(CAMERA), ColorConfig(), config, rng)

    first, again, other = read(0), read(0), read(1)
    assert np.array_equal(first.rgb, again.rgb)
    assert first.matched is not None
    assert again.matched is not None
    assert np.array_equal(first.matched, again.matched)
    assert not np.array_equal(first.rgb, other.rgb)
    assert np.array_equal(first.disparity, other.disparity)
    assert np.abs(first.matched[first.matched > 0] - 20.0).mean() < 0.3


LENS = PinholeCamera(320, 200, 240.0, 240.0, 158.2, 101.7, Distortion(k1=-0.3, k2=0.1, p1=0.002))
BASELINE, NEAR, FAR = 0.2, 2.0, 6.0


def board_depth(eye: float) -> np.ndarray:
    """Depth of a board of 0.8 x 0.8 m before a wall, from a camera that stands ``eye`` to the right (m)."""
    x, y, _ = np.moveaxis(LENS.rays() * NEAR, -1, 0)
    return np.where((np.abs(x + eye) < 0.4) & (np.abs(y) < 0.4), NEAR, FAR).astype(np.float32)


def test_both_see_what_is_neither_hidden_nor_outside() -> None:
    left, right = (gt_disparity(board_depth(eye), LENS.fx, BASELINE) for eye in (0.0, BASELINE))
    found = both_see(left, right, LENS)
    points = LENS.rays() * board_depth(0.0)[..., None].astype(float)
    crossing = points + (np.array([BASELINE, 0.0, 0.0]) - points) * ((points[..., 2:] - NEAR) / points[..., 2:])
    hidden = (points[..., 2] > NEAR + 1) & (np.abs(crossing[..., :2]) < 0.4).all(axis=-1)
    uv = LENS.project(points - [BASELINE, 0.0, 0.0])
    inside = ((uv > -0.5) & (uv < [LENS.width - 0.5, LENS.height - 0.5])).all(axis=-1)
    expected = inside & ~hidden
    assert 0.02 < hidden.mean() < 0.2
    assert (found == expected).mean() > 0.985


def test_matching_needs_straight_rows_and_gets_them() -> None:
    """A textured wall, 3 m away and turned, seen by both cameras: its true disparity is found behind the lens, too."""
    noise = np.random.default_rng(5).integers(0, 256, (700, 1000, 3)).astype(np.float32)
    paint = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 2.0), None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)

    def seen_from(eye: float) -> tuple[np.ndarray, np.ndarray]:
        x, y, _ = np.moveaxis(LENS.rays(), -1, 0)
        depth = (3.0 - 0.4 * eye) / (1.0 + 0.4 * x)  # z = 3 - 0.4 X in the left camera's frame
        place = [(500 + 130 * (x * depth + eye)).astype(np.float32), (350 + 130 * y * depth).astype(np.float32)]
        return cv2.remap(paint, *place, cv2.INTER_LINEAR), depth.astype(np.float32)

    (left, depth), (right, _) = seen_from(0.0), seen_from(BASELINE)
    true = gt_disparity(depth, LENS.fx, BASELINE)
    found = match(left, right, SgbmConfig(disparities=64), LENS)
    known = found > 0
    assert known.mean() > 0.8
    assert np.median(np.abs(found - true)[known]) < 0.2
    crooked = match_sgbm(left, right, SgbmConfig(disparities=64))
    corners = np.hypot(*np.moveaxis(LENS.rays()[..., :2], -1, 0)) > 0.6
    wrong = np.median(np.abs(crooked - true)[corners & (crooked > 0)])
    assert np.median(np.abs(found - true)[corners & known]) < 0.3 * wrong
