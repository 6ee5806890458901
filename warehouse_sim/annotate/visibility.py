"""Which part of an amodal mask an image holds, and how much of it is seen."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool


@dataclass(frozen=True)
class Window:
    """The rectangle that a placed mask and an image share, in the coordinates of each."""

    image: tuple[slice, slice]
    """Rows and columns of the image."""
    mask: tuple[slice, slice]
    """Rows and columns of the mask."""


def window_in_image(offset: tuple[int, int], mask_hw: tuple[int, int], image_hw: tuple[int, int]) -> Window | None:
    """Return where a mask lies in an image, or None when it misses it.

    Args:
        offset: Column and row of the mask's first pixel in the image; may be negative.
        mask_hw: Height and width of the mask.
        image_hw: Height and width of the image.
    """
    columns = _overlap(offset[0], mask_hw[1], image_hw[1])
    rows = _overlap(offset[1], mask_hw[0], image_hw[0])
    if columns is None or rows is None:
        return None
    return Window(image=(rows[0], columns[0]), mask=(rows[1], columns[1]))


def box_in_image(mask: Bool[np.ndarray, "h w"], window: Window) -> tuple[int, int, int, int] | None:
    """Return (left, top, right, bottom) in the image of the set pixels of ``mask``, the image's part at ``window``."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if columns.size == 0:
        return None
    left, top = window.image[1].start, window.image[0].start
    return int(columns[0]) + left, int(rows[0]) + top, int(columns[-1]) + left, int(rows[-1]) + top


def _overlap(start: int, length: int, limit: int) -> tuple[slice, slice] | None:
    first, last = max(start, 0), min(start + length, limit)
    return (slice(first, last), slice(first - start, last - start)) if first < last else None
