"""Masks as COCO's run lengths: column by column, the first run counts zeros; as numbers or as one string.

The string is that of the COCO API (common/maskApi.c): each count, from the fourth on as its difference from the one two
before, in digits of five bits, lowest first, the sixth bit says that more follow, and 48 is added to make letters.
"""

from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

_FIRST_LETTER, _BITS, _MORE, _SIGN = 48, 5, 0x20, 0x10
_MOST_DIGITS = 6
"""Of a count: 30 bits, more than an image has pixels."""


def run_lengths(mask: Bool[np.ndarray, "h w"]) -> dict[str, Any]:
    """Return COCO's uncompressed run lengths: ``size`` (h, w) and ``counts``."""
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


def compressed(runs: dict[str, Any]) -> dict[str, Any]:
    """Return run lengths with their counts as one string, as pycocotools writes them."""
    from pycocotools import mask as coco_mask

    counts = coco_mask.frPyObjects(runs, *runs["size"])["counts"]
    return {"size": runs["size"], "counts": counts.decode("ascii")}


def mask_of_runs(runs: Any, shape: tuple[int, int], where: str) -> Bool[np.ndarray, "h w"]:
    """Return the mask of run lengths, compressed or not.

    Args:
        runs: ``{"size": [h, w], "counts": [...] or "..."}``.
        shape: Height and width of its image.
        where: File and entry, for the message.

    Raises:
        DatasetError: Not run lengths that fill the image exactly.
    """
    size, counts = (runs.get(key) if isinstance(runs, dict) else None for key in ("size", "counts"))
    height, width = shape
    if size != [height, width]:
        raise DatasetError(f"{where}: a segmentation has the size {size!r}, its image {list(shape)} (h, w)")
    if isinstance(counts, str):
        counts = _counts_of_string(counts, where)
    if not isinstance(counts, list) or not all(type(count) is int and count >= 0 for count in counts):
        raise DatasetError(f"{where}: counts of a segmentation must be whole numbers >= 0, or COCO's string of them")
    if sum(counts) != height * width:
        raise DatasetError(f"{where}: the counts of a segmentation fill {sum(counts)} of {height * width} pixels")
    mask = np.zeros((height, width), dtype=bool)
    if len(counts) < 2 or mask.size == 0:
        return mask
    # Only columns in use are made: most masks cover few of them.
    counts = list(counts)
    last = counts[-1] if len(counts) % 2 else 0
    left, right = min(counts[0] // height, width - 1), width - last // height
    counts[0] -= left * height
    counts[-1] -= (width - right) * height if len(counts) % 2 else 0
    columns = np.repeat(np.arange(len(counts)) % 2 == 1, counts)
    mask[:, left:right] = columns.reshape(right - left, height).T
    return mask


def _counts_of_string(text: str, where: str) -> list[int]:
    codes = np.frombuffer(text.encode("utf-32-le"), np.uint32).astype(np.int64) - _FIRST_LETTER
    index, ends = np.arange(len(codes)), codes & _MORE == 0
    firsts = np.flatnonzero(np.concatenate([[True], ends[:-1]]))[: len(codes)]
    # Of each letter, how many digits of its number are before it.
    before = index - firsts[np.cumsum(np.concatenate([[0], ends[:-1]]))[: len(codes)].astype(int)]
    wrong = (codes < 0) | (codes >= 2 * _MORE) | (before >= _MOST_DIGITS)
    if wrong.any():
        letter = text[int(np.argmax(wrong))]
        raise DatasetError(f"{where}: counts of a segmentation hold {letter!r} where COCO's string has none")
    if len(codes) and not ends[-1]:
        raise DatasetError(f"{where}: counts of a segmentation end within a number; copy the file again")
    if not len(codes):
        return []
    numbers = np.add.reduceat((codes & (_MORE - 1)) << (_BITS * before), firsts)
    numbers -= np.where(codes[ends] & _SIGN, 1 << (_BITS * (before[ends] + 1)), 0)
    for start in (1, 2):
        numbers[start::2] = np.cumsum(numbers[start::2])
    found: list[int] = numbers.tolist()
    return found
