"""A colour filter before each pixel of the sensor."""

import cv2
import numpy as np
from jaxtyping import Float32, UInt8


def mosaic(linear: Float32[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w"]:
    """Return what each pixel sees behind an RGGB filter: red in even columns of even rows."""
    seen = linear[..., 1].copy()
    seen[::2, ::2] = linear[::2, ::2, 0]
    seen[1::2, 1::2] = linear[1::2, 1::2, 2]
    return seen


def demosaic(codes: UInt8[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return colours from a mosaic, along edges where there are any (OpenCV's edge-aware interpolation)."""
    # OpenCV names patterns by the second row's second and third pixel: RGGB is its BG.
    return cv2.demosaicing(codes, cv2.COLOR_BayerBG2RGB_EA)
