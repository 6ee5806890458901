"""Between linear light and the bytes of an image: one tone curve for every backend, and its inverse."""

import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.color import srgb_from_linear


def to_display(linear: Float[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return what a display shows of linear image values: a filmic curve, then sRGB.

    Args:
        linear: Values to which the exposure has been applied; what is negative counts as black.
    """
    return np.rint(255.0 * srgb_from_linear(tone_map(np.maximum(linear, 0.0)))).astype(np.uint8)


def tone_map(x: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the fit of the ACES reference tone curve (Narkowicz 2016, "ACES filmic tone mapping curve"), 0-1."""
    x = np.minimum(x, 1e4)  # far beyond white, and far from overflow
    return np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)


def inverse_tone_map(y: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the x whose ``tone_map`` is y (0-1): of ``y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14)``."""
    a, b, c = 2.51 - 2.43 * y, 0.03 - 0.59 * y, -0.14 * y
    return (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
