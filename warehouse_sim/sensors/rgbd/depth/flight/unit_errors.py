"""Constant errors of one built camera: drawn once from the number of the unit, the same in all its images."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32

Image = Float32[np.ndarray, "h w"]
_SCALARS, _PIXELS = 1, 2
"""Streams of a unit: one for its few numbers, one for its pixels."""
_MARGIN = 4.0
"""Reach of a smoothing filter, in its standard deviations."""


@lru_cache(maxsize=8)
def unit_samples(unit: int) -> tuple[float, float, float]:
    """Return what a unit draws: two standard normal numbers (offset, scale) and a phase (rad)."""
    rng = np.random.default_rng([unit, _SCALARS])
    offset, scale = rng.standard_normal(2)
    return float(offset), float(scale), float(rng.uniform(0.0, 2.0 * np.pi))


@lru_cache(maxsize=4)
def unit_pattern(unit: int, size_hw: tuple[int, int], smooth_px: float) -> Image:
    """Return a field of variance 1 that belongs to the pixels of a unit.

    Args:
        unit: Number of the unit.
        size_hw: Height and width of the image.
        smooth_px: Standard deviation of the filter that the camera smooths with (px of the image), 0 = none.
    """
    field = smooth_noise(size_hw, np.random.default_rng([unit, _PIXELS]), smooth_px)
    field.setflags(write=False)
    return field


def smooth_noise(size_hw: tuple[int, int], rng: np.random.Generator, smooth_px: float) -> Image:
    """Return Gaussian noise of variance 1 behind a Gaussian filter of standard deviation ``smooth_px``, 0 = white.

    Two pixels at a distance d are alike by ``exp(-d^2 / (4 smooth_px^2))``.
    """
    if smooth_px <= 0:
        return rng.standard_normal(size_hw, dtype=np.float32)
    margin = int(np.ceil(_MARGIN * smooth_px))
    size = 2 * margin + 1
    white = rng.standard_normal((size_hw[0] + 2 * margin, size_hw[1] + 2 * margin), dtype=np.float32)
    kernel = cv2.getGaussianKernel(size, smooth_px, cv2.CV_32F)
    # Behind a filter with weights w the variance is the sum of w^2, which is one factor along each axis.
    kernel /= np.sqrt(np.square(kernel).sum())
    smooth: Image = cv2.sepFilter2D(white, cv2.CV_32F, kernel, kernel)
    return smooth[margin : margin + size_hw[0], margin : margin + size_hw[1]]


def wiggle(ranges: Image, unambiguous_range: float, phase: float) -> Image:
    """Return the cyclic error of a unit as a fraction of its amplitude.

    Modulation is no pure sine: of its harmonics the four samples of a period let through the third and fifth, so that
    the error runs through four cycles in the unambiguous range (Lindner & Kolb 2006, "Lateral and depth calibration of
    PMD-distance sensors").

    Args:
        ranges: True range or depth (m).
        unambiguous_range: Of the modulation (m).
        phase: Of the unit (rad).
    """
    # A table of a thousandth of a cycle is exact to 0.3 % of the amplitude, and much faster than a sine a pixel.
    steps = 1024
    table = np.sin(2.0 * np.pi * np.arange(steps) / steps + phase).astype(np.float32)
    place = (ranges * np.float32(4.0 * steps / unambiguous_range)).astype(np.int32)
    return table[place & (steps - 1)]
