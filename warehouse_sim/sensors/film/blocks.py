"""Blocks of neighbouring rays, so that one question tells for all of them whether anything may be there."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, Int

_BLOCK = (8, 16)
"""Rows and columns of rays in a block."""
_MARGIN = np.deg2rad(1.0)
"""By which cones are wider than their blocks: rays of spinning sensors lie on no exact grid, and the sensor moves."""


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones that hold the rays of a block."""

    axes: Float[np.ndarray, "n 3"]
    """Unit vectors."""
    spread: Float[np.ndarray, " n"]
    """Half angle (rad)."""

    @classmethod
    def around(cls, middle: Float[np.ndarray, "n 3"], corners: Float[np.ndarray, "4 n 3"]) -> "Cones":
        """Return the cones around the directions of blocks, given by those in their middle and their corners."""
        axes, sides = (item / np.linalg.norm(item, axis=-1, keepdims=True) for item in (middle, corners))
        narrow = (axes * sides).sum(axis=-1).min(axis=0)
        return cls(axes, np.arccos(np.clip(narrow, -1.0, 1.0)) + _MARGIN)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Of a grid of rays, by rows and columns; numbers count along its rows."""

    shape: tuple[int, int]
    count: tuple[int, int]
    """Blocks down and across."""
    middle: Int[np.ndarray, " b"]
    """Ray in the middle of each."""
    corners: Int[np.ndarray, "4 b"]
    """Rays in the corners of each."""

    def rays(self, touched: Bool[np.ndarray, " b"]) -> Int[np.ndarray, " m"]:
        """Return the rays of some blocks, rising."""
        rows, columns = self.shape
        wide = touched.reshape(self.count).repeat(_BLOCK[1], axis=1)[:, :columns].repeat(_BLOCK[0], axis=0)[:rows]
        return np.flatnonzero(wide)


@lru_cache(maxsize=8)
def blocks_of(shape: tuple[int, int]) -> Blocks:
    """Return the blocks of a grid."""
    first = [np.arange(0, size, step) for size, step in zip(shape, _BLOCK, strict=True)]
    last = [np.minimum(item + step, size) - 1 for item, step, size in zip(first, _BLOCK, shape, strict=True)]

    def numbers(rows: Int[np.ndarray, " r"], columns: Int[np.ndarray, " c"]) -> Int[np.ndarray, " b"]:
        return (rows[:, None] * shape[1] + columns).ravel()

    middle = numbers((first[0] + last[0]) // 2, (first[1] + last[1]) // 2)
    corners = np.array([numbers(rows, columns) for rows in (first[0], last[0]) for columns in (first[1], last[1])])
    return Blocks(shape, (len(first[0]), len(first[1])), middle, corners)
