"""Noise and the pixels that share it, measured on depth images with known noise."""

import cv2
import numpy as np
import pytest

from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.estimators.pose.uncertainty.covariance import measure_residuals
from warehouse_sim.estimators.pose.uncertainty.features import look
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform

CAMERA = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)
T = make_transform(None, np.array([0.0, 0.0, 3.0]))


def seen(noise: float, window_px: int, shift: float = 0.0) -> tuple[RgbdImage, np.ndarray]:
    """The near face of the box, at 2.8 m, with noise that is alike over a window, before a wall at 6 m."""
    field = np.random.default_rng(1).standard_normal((240, 320))
    field = cv2.blur(field, (window_px, window_px)) * window_px
    depth = (2.8 + shift + noise * field).astype(np.float32)
    mask = np.zeros((240, 320), dtype=bool)
    half = 300.0 / 2.8 * np.array([0.5, 0.4])
    mask[int(120 - half[1]) + 2 : int(120 + half[1]) - 2, int(160 - half[0]) + 2 : int(160 + half[0]) - 2] = True
    depth[~mask] = 6.0
    return RgbdImage(CAMERA, depth, (Detection(mask, 1),)), mask


def residuals(surface: CadSurface, noise: float, window_px: int):
    image, mask = seen(noise, window_px)
    rng = np.random.default_rng(0)
    return measure_residuals(T, surface, image, mask, image.readings_in(mask, rng), rng)


@pytest.mark.parametrize("noise", [0.002, 0.01])
def test_noise_along_the_ray_is_measured(surface, noise):
    assert residuals(surface, noise, 1).along_ray == pytest.approx(noise, rel=0.15)


@pytest.mark.parametrize(("window_px", "low", "high"), [(1, 1.0, 2.5), (5, 12.0, 50.0), (11, 60.0, 250.0)])
def test_pixels_that_share_an_error_are_counted(surface, window_px, low, high):
    """A moving average over k x k pixels has k^2 pixels to an error."""
    assert low <= residuals(surface, 0.01, window_px).correlated_px <= high


def test_a_wrong_pose_is_seen(surface):
    image, mask = seen(0.003, 1)
    right, wrong = (
        look(T @ make_transform(None, np.array(shift)), surface, image, mask, 1.0, None, np.random.default_rng(0))
        for shift in ([0.0, 0.0, 0.0], [0.25, 0.0, 0.0])
    )
    assert right.features["verification"] > wrong.features["verification"] + 0.2
    assert right.features["sharpness"] > 0.0
    assert right.features["sharpness"] > wrong.features["sharpness"]
    assert right.features["explained"] > wrong.features["explained"]


def test_the_covariance_grows_with_the_noise_and_where_less_is_seen(surface):
    def spread(noise: float, keep: slice) -> float:
        image, mask = seen(noise, 5)
        part = np.zeros_like(mask)
        part[:, keep] = mask[:, keep]
        return look(T, surface, image, part, 1.0, None, np.random.default_rng(0)).features["log_surface"]

    whole = spread(0.003, slice(None))
    assert spread(0.02, slice(None)) > whole + 0.2
    assert spread(0.003, slice(120)) > whole


def test_an_estimate_without_readings_is_not_looked_at(surface):
    image, mask = seen(0.003, 1)
    nothing = RgbdImage(CAMERA, np.zeros_like(image.depth), image.detections)
    assert look(T, surface, nothing, mask, 1.0, None, np.random.default_rng(0)) is None
