"""Shot and read noise of an image sensor, stated in linear light and applied to sRGB pixels."""

from statistics import NormalDist

import cv2
import numpy as np
from jaxtyping import Float32, UInt8


def add_color_noise(
    rgb: UInt8[np.ndarray, "h w 3"], rng: np.random.Generator, *, shot: float, read: float
) -> UInt8[np.ndarray, "h w 3"]:
    """Return ``rgb`` with noise of variance ``shot * x + read`` in linear light x (1 = white).

    The model is that of Brooks et al. 2019, "Unprocessing images for learned raw denoising", section 3.1. It is carried
    through the sRGB curve to first order, which holds while the noise is small against the signal.

    Args:
        rgb: Clean sRGB pixels.
        rng: Source of the noise.
        shot: Variance per linear value.
        read: Variance that is always there.
    """
    if shot == 0 and read == 0:
        return rgb
    # Noise of a few codes needs no finer draw than 256 equally likely Gaussian quantiles, which cost one byte each.
    draws = np.frombuffer(rng.bytes(rgb.size), np.uint8).reshape(rgb.shape)
    noise = cv2.multiply(cv2.LUT(draws, _QUANTILES), cv2.LUT(rgb, sigma_of_code(shot, read)))
    return cv2.add(rgb, noise, dtype=cv2.CV_8U)  # rounds and saturates


def sigma_of_code(shot: float, read: float) -> Float32[np.ndarray, " 256"]:
    """Return the standard deviation, in 8-bit sRGB codes, at each of the 256 codes."""
    code = np.arange(256) / 255.0
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    slope = np.where(code <= 0.04045, 12.92, 1.055 / 2.4 * np.maximum(linear, 1e-6) ** (1.0 / 2.4 - 1.0))
    return (255.0 * slope * np.sqrt(shot * linear + read)).astype(np.float32)


def _unit_quantiles() -> Float32[np.ndarray, " 256"]:
    values = np.array([NormalDist().inv_cdf((k + 0.5) / 256) for k in range(256)])
    return (values / values.std()).astype(np.float32)


_QUANTILES = _unit_quantiles()
