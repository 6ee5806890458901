"""Boxes in range images: of what has the same id, and which points lie in one; a box may pass the image's end."""

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.estimators.sweep.grid import SweepGrid
from warehouse_sim.estimators.sweep.range_image import RangeImage
from warehouse_sim.geometry.overlap import box_coverage, box_ious

Box = Float[np.ndarray, " 4"]
"""Left, top, right, bottom of edges (px), left in [0, columns); the right may lie beyond the last column."""


def id_boxes(image: RangeImage, ids: Int[np.ndarray, " n"], wanted: Int[np.ndarray, " k"]) -> Float[np.ndarray, "k 4"]:
    """Return the box about the pixels that show points of each id, NaN where none does.

    Args:
        image: Of the sweep.
        ids: Of each of its points.
        wanted: Ids to look for.
    """
    seen = np.where(image.shown >= 0, np.append(ids, 0)[image.shown], 0) if len(ids) else np.zeros_like(image.shown)
    row, column = np.nonzero(np.isin(seen, wanted[wanted != 0]))
    of = seen[row, column]
    boxes = np.full((len(wanted), 4), np.nan)
    order = np.argsort(of, kind="stable")
    starts = np.searchsorted(of[order], wanted), np.searchsorted(of[order], wanted, side="right")
    for box, first, after in zip(boxes, *starts, strict=True):
        if after > first:
            mine = order[first:after]
            left, right = _span(column[mine], image.grid.config.columns)
            box[:] = left, row[mine].min(), right, row[mine].max() + 1.0
    return boxes


def _span(columns: Int[np.ndarray, " n"], width: int) -> tuple[int, int]:
    """Return the edges of the shortest stretch of a ring that holds some of its columns."""
    present = np.unique(columns)
    gap = np.diff(np.append(present, present[0] + width))
    widest = int(gap.argmax())
    left = int(present[(widest + 1) % len(present)])
    return left, left + width - int(gap[widest]) + 1


def in_box(grid: SweepGrid, points: Float[np.ndarray, "n 3"], box: Box) -> Bool[np.ndarray, " n"]:
    """Return which points (LiDAR frame, m) lie in a box, its edges included; it may leave the image at any side."""
    u, v = grid.places(points).T
    left, top, right, bottom = box
    across = np.abs(grid.apart(u, np.full_like(u, (left + right) / 2.0))) <= (right - left) / 2.0
    return np.asarray(across & (v >= top) & (v <= bottom))


def ring_overlaps(
    a: Float[np.ndarray, "n 4"], b: Float[np.ndarray, "m 4"], columns: int
) -> tuple[Float[np.ndarray, "n m"], Float[np.ndarray, "n m"]]:
    """Return intersection over union of boxes, and the fraction of each of ``a`` in each of ``b``, on whatever turn.

    Args:
        a: Left, top, right, bottom of edges (px); each may pass the image's end.
        b: The same.
        columns: Of a turn.
    """
    turns = [b + np.array([turn, 0, turn, 0]) for turn in (-columns, 0, columns)]
    ious = np.max([box_ious(a, boxes) for boxes in turns], axis=0)
    return ious, np.max([box_coverage(a, boxes) for boxes in turns], axis=0)


def on_turn(box: Box, columns: int) -> Box:
    """Return the same box with its left edge in [0, columns)."""
    turns = np.floor(box[0] / columns) * columns
    return np.asarray(box - np.array([turns, 0.0, turns, 0.0]))
