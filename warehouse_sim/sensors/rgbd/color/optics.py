"""What lens and housing do to light before it falls on the pixels."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera

_HALO_FRACTION = 0.5
"""Of the scattered light, what stays near where it comes from; the rest is even. No source: a prior."""
_HALO = 1.0 / 20.0
"""Standard deviation of the halo over the image's width. No source: a prior."""
_COARSE_PX = 16
"""Edge of the blocks in which scattered light is spread: it has no detail."""


def spread_points(linear: Float32[np.ndarray, "h w 3"], sigma_px: float) -> Float32[np.ndarray, "h w 3"]:
    """Return the image behind a Gaussian point spread of ``sigma_px``; its light is kept away from the border."""
    if sigma_px == 0:
        return linear
    reach = 2 * max(1, round(2.5 * sigma_px)) + 1
    return cv2.GaussianBlur(linear, (reach, reach), sigma_px, borderType=cv2.BORDER_REPLICATE)


def add_glare(linear: Float32[np.ndarray, "h w 3"], fraction: float) -> Float32[np.ndarray, "h w 3"]:
    """Return the image with ``fraction`` of its light scattered: half evenly, half as a halo about what is bright.

    ISO 9358 calls the fraction veiling glare (index); photographic lenses have 1-5 %. Brightness clips only afterwards,
    so that a door in the sun veils what is before it. The sum of the light stays, but for the halo beyond the border.
    """
    if fraction == 0:
        return linear
    height, width = linear.shape[:2]
    size = (max(width // _COARSE_PX, 1), max(height // _COARSE_PX, 1))
    coarse = cv2.resize(linear, size, interpolation=cv2.INTER_AREA)
    mean = coarse.mean(axis=(0, 1))
    sigma = max(_HALO * size[0], 0.5)
    halo = cv2.GaussianBlur(coarse, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    scattered = np.float32(fraction) * (np.float32(_HALO_FRACTION) * halo + np.float32(1.0 - _HALO_FRACTION) * mean)
    veil = cv2.resize(scattered.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR)
    return cv2.addWeighted(linear, 1.0 - fraction, veil, 1.0, 0.0)


@lru_cache(maxsize=8)
def vignetting_factor(camera: PinholeCamera, fraction: float) -> Float32[np.ndarray, "h w 1"]:
    """Return the light that reaches each pixel relative to the axis: cos^4 of the angle to it, softened."""
    if camera.distortion is None:
        x = (np.arange(camera.width) - camera.cx) / camera.fx
        y = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    else:
        x, y, _ = np.moveaxis(camera.rays(), -1, 0)
    cosine4 = (1.0 + x * x + y * y) ** -2.0
    factor = (1.0 - fraction * (1.0 - cosine4)).astype(np.float32)[..., None]
    factor.setflags(write=False)
    return factor
