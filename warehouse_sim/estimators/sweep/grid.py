"""Directions of a LiDAR as pixels of a range image, and back: azimuth along the rows, elevation along the columns."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.estimators.sweep.settings import RangeImageConfig


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
