"""Masks as COCO's run lengths: column by column, the first run counts zeros."""

from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

_LONGEST_TEXT = 2**24
"""Characters of packed run lengths that are read."""


def run_lengths(mask: Bool[np.ndarray, "h w"]) -> dict[str, Any]:
    """Return COCO's uncompressed run lengths: column by column, the first run counts zeros."""
    box = mask_box_xyxy(mask)
    height, width = mask.shape
    if box is None:
        return {"size": [height, width], "counts": [height * width]}
    left, _, right, _ = box
    # Only the columns in use are read; the empty ones on both sides lengthen the first and the last run.
    columns = mask[:, left : right + 1].T.ravel()
    changes = np.flatnonzero(np.diff(columns, prepend=False, append=False)) + left * height
    counts = np.diff(changes, prepend=0, append=height * width)
    return {"size": [height, width], "counts": counts[: len(counts) - (counts[-1] == 0)].tolist()}


def mask_of_runs(data: Any, size_hw: tuple[int, int], where: str) -> Bool[np.ndarray, "h w"]:
    """Return the mask of COCO's run lengths, as a list of numbers or packed into a text.

    Args:
        data: ``{"size": [h, w], "counts": [...] or "..."}``.
        size_hw: Height and width of the image.
        where: File and object, for the message.

    Raises:
        DatasetError: Not run lengths that fill this image.
    """
    size, counts = (data.get(key) if isinstance(data, dict) else None for key in ("size", "counts"))
    if size != list(size_hw):
        raise DatasetError(f"{where}: run lengths have the size {str(size)[:40]}, the image {list(size_hw)} (h, w)")
    runs = _unpacked(counts, where) if isinstance(counts, str) else counts
    if not isinstance(runs, list) or not all(type(run) is int and run >= 0 for run in runs):
        raise DatasetError(f"{where}: counts of run lengths must be whole numbers >= 0, or the text that packs them")
    # Summed before anything of that length is made.
    if sum(runs) != size_hw[0] * size_hw[1]:
        raise DatasetError(f"{where}: run lengths fill {sum(runs)} of {size_hw[0] * size_hw[1]} pixels")
    flat = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return np.ascontiguousarray(flat.reshape(size_hw[1], size_hw[0]).T)


def _unpacked(text: str, where: str) -> list[int]:
    """Return the numbers of COCO's packed counts.

    As pycocotools packs them: five bits a character from "0" on, the lowest first, the sixth bit says that more follow,
    the last one's highest bit is the sign; from the fourth number on they are differences from the one two before.
    """
    if len(text) > _LONGEST_TEXT:
        raise DatasetError(f"{where}: run lengths of {len(text)} characters; {_LONGEST_TEXT} are read")
    runs: list[int] = []
    value = shift = 0
    for character in text:
        bits = ord(character) - 48
        if not 0 <= bits < 64 or shift > 60:
            raise DatasetError(f"{where}: {character!r} does not belong into packed run lengths")
        value |= (bits & 31) << shift
        shift += 5
        if bits & 32:
            continue
        if bits & 16:
            value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
        value = shift = 0
    if shift:
        raise DatasetError(f"{where}: packed run lengths end in the middle of a number")
    return runs
