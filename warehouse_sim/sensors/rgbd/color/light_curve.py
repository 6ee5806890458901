"""Between the bytes of a rendered image and the linear light behind them: the display curve, both ways."""

from functools import cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.color import linear_from_srgb
from warehouse_sim.render.display import inverse_tone_map, to_display

_BRIGHTEST = 8.0
"""Linear value that the finest table reaches; 7.2 is shown as full white."""
_STEPS = 65535


def linear_light(rgb: UInt8[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w 3"]:
    """Return the linear image values (1 = what just saturates at the exposure) that are shown as ``rgb``."""
    return cv2.LUT(rgb, _linear_of_code())


def display_codes(linear: Float32[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return what a display shows of linear values, as ``render.display`` does, but by table."""
    # Saturates at both ends; one step is at most 0.15 of a code.
    steps = cv2.multiply(linear, _STEPS / _BRIGHTEST, dtype=cv2.CV_16U)
    return np.take(_code_of_step(), steps)


@cache
def _linear_of_code() -> Float32[np.ndarray, " 256"]:
    return inverse_tone_map(linear_from_srgb(np.arange(256) / 255.0)).astype(np.float32)


@cache
def _code_of_step() -> UInt8[np.ndarray, " 65536"]:
    linear = np.arange(_STEPS + 1) * (_BRIGHTEST / _STEPS)
    return to_display(linear[None, :, None].repeat(3, axis=2))[0, :, 0].copy()
