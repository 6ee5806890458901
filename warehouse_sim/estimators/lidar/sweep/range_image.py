"""The range image of a sweep: its pixels, which point each shows, and boxes in it, which may pass its end."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.estimators.lidar.sweep.settings import RangeImageConfig


@dataclass(frozen=True)
class SweepGrid:
    """Coordinates of *edges*: pixel (u, v) reaches from (u, v) to (u + 1, v + 1); u = 0 and u = columns are the same.

    What is ahead (LiDAR's x) is in the middle column, what is to the left (y) left of it, what is behind at both ends.
    """

    config: RangeImageConfig

    @property
    def columns_per_rad(self) -> float:
        """Columns of a radian of azimuth."""
        return self.config.columns / (2.0 * np.pi)

    @property
    def rows_per_rad(self) -> float:
        """Rows of a radian of elevation."""
        low, high = np.deg2rad(self.config.elevation_deg)
        return float(self.config.rows / (high - low))

    @property
    def horizon(self) -> float:
        """Row of elevation 0; it may lie outside of the image."""
        return float(np.deg2rad(self.config.elevation_deg[1])) * self.rows_per_rad

    def places(self, points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 2"]:
        """Return u in [0, columns) and v of points (LiDAR frame, m); v may lie outside of the image."""
        x, y, z = np.asarray(points, dtype=float).T
        u = (np.pi - np.arctan2(y, x)) * self.columns_per_rad
        # An azimuth of -180 deg is one of 180.
        u = np.where(u >= self.config.columns, 0.0, u)
        return np.stack([u, self.horizon - np.arctan2(z, np.hypot(x, y)) * self.rows_per_rad], axis=1)

    def directions(self, places: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 3"]:
        """Return the unit vectors (LiDAR frame) of coordinates (u, v), any u: the inverse of ``places``."""
        u, v = np.asarray(places, dtype=float).T
        azimuth, elevation = np.pi - u / self.columns_per_rad, (self.horizon - v) / self.rows_per_rad
        level = np.cos(elevation)
        return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=1)

    def pixels(self, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n 2"]:
        """Return column and row of points (LiDAR frame, m), -1 for the row of what is not in the image."""
        places = np.floor(self.places(points)).astype(np.int64)
        places[:, 0] %= self.config.columns
        places[(places[:, 1] < 0) | (places[:, 1] >= self.config.rows), 1] = -1
        return places

    def apart(self, u: Float[np.ndarray, "*n"], other: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
        """Return u - other along the shorter way around, in [-columns / 2, columns / 2)."""
        half = self.config.columns / 2.0
        return np.asarray((u - other + half) % self.config.columns - half)


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


def on_turn(box: Box, columns: int) -> Box:
    """Return the same box with its left edge in [0, columns)."""
    turns = np.floor(box[0] / columns) * columns
    return np.asarray(box - np.array([turns, 0.0, turns, 0.0]))
