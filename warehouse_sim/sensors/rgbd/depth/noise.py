"""Random fields that neighbouring pixels share, as the pixels of a matching window do."""

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
