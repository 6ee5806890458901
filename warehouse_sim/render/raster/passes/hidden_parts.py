"""Which parts nothing is seen of, as all of their bounding box lies behind what is already drawn.

A hierarchical depth buffer (Greene, Kass and Miller 1993, "Hierarchical z-buffer visibility") of the farthest depths.
It leaves out what would fail the depth test in every pixel, so that images stay as they are, bit by bit.
"""

from dataclasses import dataclass

import moderngl
import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raster.meshes.parts import PartTable
from warehouse_sim.render.raster.projection import NEAR, box_bounds

_CELLS = 4
"""A box is looked up where it spans at most so many cells each way, and one more as it begins in one."""
_MARGIN_PX = 1.0
"""Boxes count as this much larger in the image,"""
_CLOSER = 1.0 + 1e-4
"""and as this much nearer, so that rounding hides nothing."""


@dataclass(frozen=True, eq=False)
class DepthPyramid:
    """Stored depths (near / z, 0 where there is nothing) of an image, and of ever larger cells the farthest of each."""

    levels: tuple[Float32[np.ndarray, "_ _"], ...]
    """The image itself first; a cell of the next level holds 2 x 2 of the one before."""

    @classmethod
    def of(cls, stored: Float32[np.ndarray, "h w"]) -> "DepthPyramid":
        """Halve ``stored`` until one cell is left; what a cell lacks beyond the border does not count."""
        levels = [stored]
        while max(levels[-1].shape) > 1:
            last = levels[-1]
            odd = [(0, size % 2) for size in last.shape]
            last = np.pad(last, odd, mode="edge") if any(more for _, more in odd) else last
            rows = np.minimum(last[::2], last[1::2])
            levels.append(np.minimum(rows[:, ::2], rows[:, 1::2]))
        return cls(tuple(levels))

    @classmethod
    def read(cls, depth: moderngl.Texture, size: tuple[int, int]) -> "DepthPyramid":
        """Read what is rendered so far from a depth texture of ``size`` (width, height)."""
        stored = np.empty((size[1], size[0]), np.float32)
        depth.read_into(stored)
        return cls.of(stored)

    def hides(
        self, camera: PinholeCamera, table: PartTable, records: np.ndarray, rows: Int[np.ndarray, " k"]
    ) -> Bool[np.ndarray, " k"]:
        """Return which of ``rows`` cannot be seen.

        Args:
            camera: Intrinsics.
            table: The parts.
            records: The table placed in the camera frame.
            rows: Rows of the table.
        """
        rotation = np.swapaxes(records["rotation"][rows], 1, 2).astype(float)
        middle, half = table.local_centre[rows], table.half_size[rows]
        translation = records["translation"][rows].astype(float)
        low, high = box_bounds(camera, rotation, translation, middle, half)
        depth = (rotation[:, 2] * middle).sum(axis=1) + translation[:, 2] - (np.abs(rotation[:, 2]) * half).sum(axis=1)
        whole = depth > NEAR  # what the near plane cuts is all around the camera
        hidden = np.zeros(len(rows), bool)
        nearest = NEAR / depth[whole] * _CLOSER
        hidden[whole] = nearest < self._farthest(low[whole] - _MARGIN_PX, high[whole] + _MARGIN_PX)
        return hidden

    def _farthest(self, low: Float[np.ndarray, "k 2"], high: Float[np.ndarray, "k 2"]) -> Float[np.ndarray, " k"]:
        """Return a depth that no pixel between ``low`` and ``high`` (u, v) is behind; 0 outside of the image."""
        height, width = self.levels[0].shape
        inside = ((high >= 0) & (low <= [width - 1, height - 1])).all(axis=1)
        first = np.clip(np.floor(low), 0, [width - 1, height - 1]).astype(int)
        last = np.clip(np.ceil(high), 0, [width - 1, height - 1]).astype(int)
        span = (last - first + 1).max(axis=1)
        level = np.ceil(np.log2(np.maximum(span / _CELLS, 1.0))).astype(int)
        farthest = np.zeros(len(low))
        for number, cells in enumerate(self.levels):
            mine = np.flatnonzero(inside & (np.minimum(level, len(self.levels) - 1) == number))
            if len(mine) == 0:
                continue
            step = np.arange(_CELLS + 1)
            x, y = (
                np.minimum((first[mine, axis] >> number)[:, None] + step, (last[mine, axis] >> number)[:, None])
                for axis in (0, 1)
            )
            farthest[mine] = cells[y[:, :, None], x[:, None, :]].min(axis=(1, 2))
        return farthest
