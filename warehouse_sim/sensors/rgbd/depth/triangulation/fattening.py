"""Edges of near things as windows match them: too wide, and ragged."""

import cv2
import numpy as np
from jaxtyping import Bool, Float32

Image = Float32[np.ndarray, "h w"]


def fattened(
    disparity: Image, reach_px: float, swing: Image, least_step_px: float
) -> tuple[Image, Bool[np.ndarray, "h w"]]:
    """Return disparities where near things have grown over what is behind them, and where they have.

    A window on the far side of a step holds some of the near side, whose texture wins as far as ``reach_px``. Slopes
    are left alone.

    Args:
        disparity: True disparity (px of any image), 0 = nothing there.
        reach_px: By how much things grow on either side (image pixels).
        swing: Noise of variance 1 that makes the border ragged; by a quarter of the reach.
        least_step_px: Least step of disparity that counts (in its unit).
    """
    near, far = (_grown(disparity, fraction * reach_px) for fraction in (0.75, 1.25))
    wide: Image = cv2.copyTo(far, (swing > 0).view(np.uint8), near)
    grew = cv2.subtract(wide, disparity) > np.float32(least_step_px)
    return cv2.copyTo(wide, grew.view(np.uint8), disparity.copy()), grew


def widened(shadow: Bool[np.ndarray, "h w"], reach_px: float, to_left: bool, swing: Image) -> Bool[np.ndarray, "h w"]:
    """Return a shadow that reaches further to one side.

    Args:
        shadow: What a second eye does not see.
        reach_px: By how much, on average (px).
        to_left: Whether to the left: the side of the near thing's shadow that is away from the thing.
        swing: Noise of variance 1; decides between the whole pixels below and above the reach.
    """
    least = int(reach_px)
    found = [_moved(shadow, step, to_left) for step in range(1, least + 2)]
    for item in found[:-1]:
        shadow = shadow | item
    # Of Gaussian noise, about a fraction p is below 1.6 (p - 0.5) / (p (1 - p) + 0.4).
    fraction = reach_px - least
    return shadow | (found[-1] & (swing < np.float32(1.6 * (fraction - 0.5) / (fraction * (1 - fraction) + 0.4))))


def _moved(image: Bool[np.ndarray, "h w"], step: int, to_left: bool) -> Bool[np.ndarray, "h w"]:
    moved = np.zeros_like(image)
    if to_left:
        moved[:, :-step] = image[:, step:]
    else:
        moved[:, step:] = image[:, :-step]
    return moved


def _grown(disparity: Image, reach_px: float) -> Image:
    size = 2 * max(round(reach_px), 0) + 1
    return cv2.dilate(disparity, np.ones((size, size), np.uint8))
