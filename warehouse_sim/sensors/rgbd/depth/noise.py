"""Random fields that neighbouring pixels share, and constant errors of one built camera."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32


def unit_noise(size_hw: tuple[int, int], rng: np.random.Generator, correlation_px: int) -> Float32[np.ndarray, "h w"]:
    """Return Gaussian noise of variance 1 that is averaged over windows of ``correlation_px`` (odd, 1 = white)."""
    margin = correlation_px // 2
    height, width = size_hw[0] + 2 * margin, size_hw[1] + 2 * margin
    white = rng.standard_normal((height, width), dtype=np.float32)
    if margin == 0:
        return white
    # The mean of n^2 independent values has the standard deviation 1 / n.
    smooth = cv2.blur(white, (correlation_px, correlation_px)) * np.float32(correlation_px)
    return smooth[margin : height - margin, margin : width - margin]


def odd_window(size_px: float) -> int:
    """Return the odd number of pixels nearest to a window's size, at least 1."""
    return 2 * round((size_px - 1) / 2) + 1 if size_px > 1 else 1


def smooth_noise(size_hw: tuple[int, int], rng: np.random.Generator, window_px: float) -> Float32[np.ndarray, "h w"]:
    """Return Gaussian noise of variance 1 that windows share; a fifth of its variance is that of larger windows.

    So no small filter removes it. It is rendered for every second pixel, that of windows three times as large for every
    eighth, and interpolated.

    Args:
        size_hw: Of the image.
        rng: Its source.
        window_px: Edge of the window (px).
    """
    fine = _interpolated(size_hw, rng, window_px, 2)
    coarse = _interpolated(size_hw, rng, 3.0 * window_px, 8)
    return cv2.addWeighted(fine, float(np.sqrt(0.8)), coarse, float(np.sqrt(0.2)), 0.0)


def border_noise(size_hw: tuple[int, int], rng: np.random.Generator, window_px: float) -> Float32[np.ndarray, "h w"]:
    """Return Gaussian noise of variance 1 that windows share, drawn for every fourth pixel: to make borders ragged.

    Args:
        size_hw: Of the image.
        rng: Its source.
        window_px: Edge of the window (px).
    """
    return _interpolated(size_hw, rng, window_px, 4)


def _interpolated(
    size_hw: tuple[int, int], rng: np.random.Generator, window_px: float, stride: int
) -> Float32[np.ndarray, "h w"]:
    """Return noise of variance 1 that is rendered for every ``stride``-th pixel."""
    window = odd_window(window_px / stride)
    small = unit_noise((-(-size_hw[0] // stride), -(-size_hw[1] // stride)), rng, window)
    size = (stride * small.shape[1], stride * small.shape[0])
    # Between two values that correlate by r, weights a and 1 - a leave a variance of 1 - 2 a (1 - a) (1 - r).
    place = (np.arange(stride) + 0.5) / stride - 0.5
    left = float(np.mean(1 - 2 * np.abs(place) * (1 - np.abs(place)) / window))
    grown = cv2.resize(small, size, interpolation=cv2.INTER_LINEAR)[: size_hw[0], : size_hw[1]]
    return grown * np.float32(1.0 / left)


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
    field = gaussian_noise(size_hw, np.random.default_rng([unit, _PIXELS]), smooth_px)
    field.setflags(write=False)
    return field


def gaussian_noise(size_hw: tuple[int, int], rng: np.random.Generator, smooth_px: float) -> Image:
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
