"""From linear light to the bytes of a picture: the same for every backend that computes light itself."""

import numpy as np
from jaxtyping import Float, UInt8


def to_display(linear: Float[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return what a display shows of linear image values: a filmic curve, then sRGB.

    Args:
        linear: Values to which the exposure has been applied; what is negative counts as black.
    """
    return np.rint(255.0 * srgb(tone_map(np.maximum(linear, 0.0)))).astype(np.uint8)


def tone_map(x: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the fit of the ACES reference tone curve (Narkowicz 2016, "ACES filmic tone mapping curve"), 0-1."""
    x = np.minimum(x, 1e4)  # far beyond white, and far from overflow
    return np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)


def srgb(x: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the sRGB code (0-1) of linear light (0-1), by IEC 61966-2-1."""
    return np.where(x > 0.0031308, 1.055 * np.power(x, 1.0 / 2.4) - 0.055, 12.92 * x)
