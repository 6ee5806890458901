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
