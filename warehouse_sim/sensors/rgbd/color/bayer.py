"""A colour filter before each pixel of the sensor."""

import cv2
import numpy as np
from jaxtyping import Float32

_WHITE = 8.0
"""Linear value at the sensor's largest number, 16 bits."""


def mosaic(linear: Float32[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w"]:
    """Return what each pixel sees behind an RGGB filter: red in even columns of even rows."""
    seen = linear[..., 1].copy()
    seen[::2, ::2] = linear[::2, ::2, 0]
    seen[1::2, 1::2] = linear[1::2, 1::2, 2]
    return seen


def demosaic(raw: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "h w 3"]:
    """Return colours from a mosaic, along edges where there are any (OpenCV's edge-aware interpolation)."""
    steps = cv2.multiply(raw, 65535.0 / _WHITE, dtype=cv2.CV_16U)
    # OpenCV names patterns by the second row's second and third pixel: RGGB is its BG.
    return cv2.demosaicing(steps, cv2.COLOR_BayerBG2RGB_EA).astype(np.float32) * np.float32(_WHITE / 65535.0)
