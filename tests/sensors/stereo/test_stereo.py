import cv2
import numpy as np
import pytest

from tests.sensors.targets import plane
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.stereo import (
    SgbmConfig,
    StereoConfig,
    gt_disparity,
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
