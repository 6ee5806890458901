"""From the bytes of a rendered image back to the linear light behind them."""

from functools import cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.color import linear_from_srgb
from warehouse_sim.render.display import inverse_tone_map


def linear_light(rgb: UInt8[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w 3"]:
    """Return the linear image values (1 = what just saturates at the exposure) that are shown as ``rgb``."""
    return cv2.LUT(rgb, _linear_of_code())


@cache
def _linear_of_code() -> Float32[np.ndarray, " 256"]:
    return inverse_tone_map(linear_from_srgb(np.arange(256) / 255.0)).astype(np.float32)
