"""The range image of a sweep: which point each pixel shows. Rows between beams show the nearer one's."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.estimators.sweep.grid import SweepGrid

_MOST_REACH = 16
"""Rows that a reading fills above and below at most; beams farther apart leave gaps."""


@dataclass(frozen=True, eq=False)
class RangeImage:
    """A sweep seen from its own sensor; see ``SweepGrid`` for its pixels."""

    grid: SweepGrid
    shown: Int[np.ndarray, "h w"]
    """Which point each pixel shows, -1 = none."""
    range: Float32[np.ndarray, "h w"]
    """Metres from the LiDAR (not along an axis), 0 = no reading."""

    def of_points(self, values: Float[np.ndarray, " n"], fill: float = 0.0) -> Float32[np.ndarray, "h w"]:
        """Return a value of each point as an image; ``fill`` where there is no reading."""
        if not len(values):
            return np.full(self.shown.shape, fill, dtype=np.float32)
        return np.where(self.shown >= 0, np.asarray(values)[self.shown], fill).astype(np.float32)


def range_image(points: Float[np.ndarray, "n 3"], grid: SweepGrid) -> RangeImage:
    """Return the range image of a sweep.

    Of the points of a pixel the nearest wins. Then an empty pixel shows what the next one on its left shows, else on
    its right, then what the nearest filled row of its column shows (of two the upper), as far as half the usual
    distance of beams; nothing is averaged.

    Args:
        points: LiDAR frame (m), in any order.
        grid: Which directions are which pixels.
    """
    points = np.asarray(points, dtype=float)
    distance = np.linalg.norm(points, axis=1)
    shown = _down(_beside(_nearest(points, distance, grid)))
    image = np.where(shown >= 0, distance[shown], 0.0) if len(points) else np.zeros(shown.shape)
    return RangeImage(grid, shown, image.astype(np.float32))


def _nearest(
    points: Float[np.ndarray, "n 3"], distance: Float[np.ndarray, " n"], grid: SweepGrid
) -> Int[np.ndarray, "h w"]:
    """Return the number of the nearest point of each pixel."""
    u, v = grid.pixels(points).T
    inside = np.flatnonzero((v >= 0) & (distance > 0.0))
    order = inside[np.argsort(distance[inside], kind="stable")]
    cell, first = np.unique(v[order] * grid.config.columns + u[order], return_index=True)
    shown = np.full(grid.config.rows * grid.config.columns, -1, dtype=np.int64)
    shown[cell] = order[first]
    return shown.reshape(grid.config.rows, grid.config.columns)


def _beside(shown: Int[np.ndarray, "h w"]) -> Int[np.ndarray, "h w"]:
    """Fill single columns, which the scan's steps leave now and then; behind, the image goes on at its other end."""
    # Only in rows that a beam passes: elsewhere the rows are filled from their column.
    passed = (shown >= 0).mean(axis=1, keepdims=True) > 0.5
    left, right = np.roll(shown, 1, axis=1), np.roll(shown, -1, axis=1)
    return np.where((shown >= 0) | ~passed, shown, np.where(left >= 0, left, right))


def _down(shown: Int[np.ndarray, "h w"]) -> Int[np.ndarray, "h w"]:
    """Fill rows between beams."""
    reach = _reach(shown >= 0)
    row = np.arange(len(shown))[:, None]
    above = np.maximum.accumulate(np.where(shown >= 0, row, -len(shown)), axis=0)
    below = np.minimum.accumulate(np.where(shown >= 0, row, 2 * len(shown))[::-1], axis=0)[::-1]
    source = np.where(row - above <= below - row, above, below)
    near = np.abs(source - row) <= reach
    filled = np.take_along_axis(shown, np.clip(source, 0, len(shown) - 1), axis=0)
    return np.where(near, filled, -1)


def _reach(has: Bool[np.ndarray, "h w"]) -> int:
    """Return half the distance (rows) of neighbouring beams, as three quarters of the gaps in columns are."""
    column, row = np.nonzero(has.T)
    gaps = np.diff(row)[np.diff(column) == 0]
    return min(_MOST_REACH, int(np.ceil(np.percentile(gaps, 75) / 2.0))) if len(gaps) else 0
