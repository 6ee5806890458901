"""A picked order: pieces of several sizes, each put where it rests lowest, as an order picker builds a pallet.

Each piece owns a cell, its base grown by the gap; cells never overlap where pieces overlap in height, and a piece is
shifted and turned only inside its cell. So no two pieces can touch, whatever is sampled.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene.packing.patterns import carried
from warehouse_sim.scene.packing.stacking import AIR, StackingConfig

_LEAST_CARRIED = 0.7
"""Least fraction of a piece's base that must rest on what is below."""
_LEVEL = 1e-6
"""Tops that differ by less than this (m) carry a piece together."""


@dataclass(frozen=True, eq=False)
class _Cells:
    """What has been placed so far."""

    low: Float[np.ndarray, "n 2"]
    """Lower corners of the cells (m)."""
    high: Float[np.ndarray, "n 2"]
    """Upper corners of the cells (m)."""
    top: Float[np.ndarray, " n"]
    """Heights of the pieces' tops (m)."""
    number: Int[np.ndarray, " n"]
    """Numbers of the pieces."""

    def grown(self, low: np.ndarray, high: np.ndarray, top: float, number: int) -> "_Cells":
        return _Cells(
            np.vstack([self.low, low]),
            np.vstack([self.high, high]),
            np.append(self.top, top),
            np.append(self.number, number),
        )


@dataclass(frozen=True, eq=False)
class Rests:
    """What may rest on what, and on how much of its base."""

    allowed: Bool[np.ndarray, "n n"]
    """Whether each piece (row) may rest on each other (column)."""
    least: float = _LEAST_CARRIED
    """Least fraction of a piece's base that must rest on what is below."""

    @classmethod
    def anywhere(cls, count: int) -> "Rests":
        """Return leave for ``count`` pieces to rest on each other in any order."""
        return cls(np.ones((count, count), bool))


def pack_mixed(
    sizes: Sequence[Float[np.ndarray, " 3"]],
    area: tuple[float, float],
    height: float,
    config: StackingConfig,
    rng: np.random.Generator,
    rests: Rests | None = None,
) -> list[tuple[int, Transform]]:
    """Stack as many of ``sizes`` as fit over a surface at z = 0.

    Args:
        sizes: Edges (m) of the pieces in the order in which they are taken; heavy ones first make a steady load.
        area: Edges of the surface along x and y (m); no cell leaves it.
        height: Greatest height of the load (m).
        config: How carefully pieces are stacked; its layer settings do not apply.
        rng: Stream to draw from.
        rests: What may rest on what; by default anything on anything.

    Returns:
        Number of the piece in ``sizes`` and pose of its centre; pieces that found no place are missing.
    """
    gap = config.gap_mm / 1000
    cells = _Cells(np.empty((0, 2)), np.empty((0, 2)), np.empty(0), np.empty(0, int))
    leave = Rests.anywhere(len(sizes)) if rests is None else rests
    placed = []
    for number, size in enumerate(sizes):
        bars = ~leave.allowed[number, cells.number]
        found = _lowest_place(cells, size, area, height, gap, bars, leave.least)
        if found is None:
            continue
        low, bottom, turned = found
        base = (size[1::-1] if turned else size[:2]) + gap
        cells = cells.grown(low, low + base, bottom + size[2], number)
        centre = np.append(low + base / 2, bottom + size[2] / 2)
        placed.append((number, _inside_its_cell(centre, size, turned, base, config, rng)))
    return placed


def _lowest_place(
    cells: _Cells,
    size: Float[np.ndarray, " 3"],
    area: tuple[float, float],
    height: float,
    gap: float,
    bars: Bool[np.ndarray, " n"],
    least: float,
) -> tuple[Float[np.ndarray, " 2"], float, bool] | None:
    """Return lower corner (m), height (m) and quarter turn of the lowest place; of equals the one nearest a corner."""
    start, end = -np.array(area) / 2, np.array(area) / 2
    best: tuple[tuple[float, ...], np.ndarray, float, bool] | None = None
    for turned in (False, True):
        base = (size[1::-1] if turned else size[:2]) + gap
        edges = [np.unique(np.append(cells.high[:, axis], start[axis])) for axis in (0, 1)]
        low = np.stack(np.meshgrid(*edges, indexing="ij"), axis=-1).reshape(-1, 2)
        low = low[np.all(low + base <= end + 1e-9, axis=1)]
        if not len(low):
            continue
        bottom, fraction = _rest(cells, low, low + base, bars)
        good = (fraction >= least) & (bottom + size[2] <= height)
        if not good.any():
            continue
        rank = np.column_stack([np.round(bottom, 4), (low - start).sum(axis=1)])
        index = np.flatnonzero(good)[np.lexsort((rank[good, 1], rank[good, 0]))[0]]
        if best is None or tuple(rank[index]) < best[0]:
            best = tuple(rank[index]), low[index], float(bottom[index]), turned
    return None if best is None else best[1:]


def _rest(
    cells: _Cells, low: np.ndarray, high: np.ndarray, bars: Bool[np.ndarray, " n"]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the height (m) at which each rectangle comes to rest and the fraction of it that is carried there.

    Nothing is carried where a piece is touched that ``bars``.
    """
    over = np.all((low[:, None] < cells.high - 1e-9) & (high[:, None] > cells.low + 1e-9), axis=2)
    top = np.where(over, cells.top, 0.0).max(axis=1, initial=0.0)
    fraction = np.ones(len(low))
    for level in np.unique(top[top > 0.0]):
        rows, below = np.flatnonzero(top == level), np.abs(cells.top - level) < _LEVEL
        fraction[rows] = carried(low[rows], high[rows], cells.low[below], cells.high[below])
        fraction[rows[(over[rows] & below & bars).any(axis=1)]] = 0.0
    return top + AIR, fraction


def _inside_its_cell(
    centre: np.ndarray,
    size: np.ndarray,
    turned: bool,
    base: np.ndarray,
    config: StackingConfig,
    rng: np.random.Generator,
) -> Transform:
    """Draw turn and shift, and cut them to what the cell leaves free beside 0.5 mm to the next cell."""
    yaw = np.deg2rad(config.yaw_deg.sample(rng))
    free = (base - (size[1::-1] if turned else size[:2]) - AIR) / 2
    # A turn by t moves the corners of a rectangle outwards by at most t times half its other edge.
    limit = float(np.min(free / (base[::-1] / 2)))
    yaw = float(np.clip(yaw, -limit, limit))
    free = np.maximum(free - abs(yaw) * base[::-1] / 2, 0.0)
    shift = np.array([config.shift_mm.sample(rng), config.shift_mm.sample(rng)]) / 1000
    quarter = (np.pi / 2 if turned else 0.0) + (np.pi if rng.random() < config.half_turn_fraction else 0.0)
    return make_transform(rotation_z(quarter + yaw), centre + np.append(np.clip(shift, -free, free), 0.0))
