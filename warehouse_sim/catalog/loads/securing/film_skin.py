"""The surface that stretch film takes around a load: the outline of each layer, and straight skin between layers.

A turn of film is pulled tight, so that seen from above it is the convex outline of what it goes around; from a broad
layer to a smaller one above it the skin runs straight inwards. Places on it are named by a column, which counts around
the load from its corner at -x -y, counter-clockwise, and a height.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.convex import convex_hull, grown
from warehouse_sim.geometry.mesh import TriangleMesh

COLUMNS = 40
"""Columns around a load; every ``COLUMNS / 4`` there is a corner."""
_SIDE = COLUMNS // 4
_ALONG = np.concatenate([[0.0, 0.022], np.linspace(0.022, 0.978, _SIDE - 1)[1:-1], [0.978]])
"""Where the columns of a side stand, as fractions of its length: close to the corners, so that these are rounded."""
_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_BLUNT = 0.3
"""Fraction of its distance to the goods by which film cuts a corner short."""
_SAMPLED_IN = 1.3
"""Height over which film is sampled in, over how far it is."""
_SAME = 0.008
"""Outlines that differ by less than this (m) are one."""
_FLAT = 0.002
"""Corners of an outline that stand out by no more than this (m) are left out."""
_WAVES = 5


@dataclass(frozen=True, eq=False)
class Level:
    """A layer of goods with one outline."""

    outline: Float[np.ndarray, "n 2"]
    """Convex outline of the goods, counter-clockwise (m)."""
    low: float
    """Lower edge (m)."""
    high: float
    """Upper edge (m)."""


@dataclass(frozen=True, eq=False)
class FilmSkin:
    """Film around levels of goods, as a function of column and height."""

    heights: Float[np.ndarray, " k"]
    """Heights of the rings, rising (m)."""
    rings: Float[np.ndarray, "k columns 2"]
    """Where the columns stand at each of them (m)."""
    waves: Float[np.ndarray, "waves 4"]
    """Of each wave: turns around the load, turns in a metre of height, phase, amplitude (m)."""

    @property
    def low(self) -> float:
        """Height of the lower edge (m)."""
        return float(self.heights[0])

    @property
    def high(self) -> float:
        """Height of the upper edge (m)."""
        return float(self.heights[-1])

    def points(
        self,
        column: Float[np.ndarray, " n"],
        height: Float[np.ndarray, " n"],
        proud: float | Float[np.ndarray, " n"] = 0.0,
    ) -> Float[np.ndarray, "n 3"]:
        """Return places on the film (m), ``proud`` (m) outside of it, in waves that never go inwards."""
        left = np.floor(column).astype(int)
        fraction = (column - left)[:, None]
        here, after = self._at(left % COLUMNS, height), self._at((left + 1) % COLUMNS, height)
        along = self._at((left + 2) % COLUMNS, height) - self._at((left - 1) % COLUMNS, height)
        out = np.column_stack([along[:, 1], -along[:, 0]]) / np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None]
        far = proud + self._swell(column, height)
        return np.column_stack([here + fraction * (after - here) + far[:, None] * out, height])

    def _at(self, column: np.ndarray, height: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 2"]:
        """Return where whole columns stand at heights (m)."""
        upper = np.clip(np.searchsorted(self.heights, height), 1, len(self.heights) - 1)
        low, high = self.heights[upper - 1], self.heights[upper]
        fraction = np.clip((height - low) / (high - low), 0.0, 1.0)[:, None]
        return np.asarray(self.rings[upper - 1, column] * (1.0 - fraction) + self.rings[upper, column] * fraction)

    def _swell(self, column: Float[np.ndarray, " n"], height: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        """Return how far the film stands off its tight shape (m): in slanting waves, and not at all at corners."""
        around, up, phase, size = self.waves.T
        angle = 2 * np.pi * (np.outer(column / COLUMNS, around) + np.outer(height, up)) + phase
        free = np.abs(np.sin(np.pi * column / _SIDE)) ** 0.7
        return np.asarray(np.maximum((size * np.sin(angle)).sum(axis=1), 0.0) * free)


def film_skin(levels: Sequence[Level], away: float, slack: float, rng: np.random.Generator) -> FilmSkin:
    """Return the film around ``levels``, given from the ground up.

    Args:
        levels: Layers of goods that stand on each other.
        away: Least distance of the film from them (m).
        slack: How loose it is, 0-1.
        rng: Stream to draw the waves from.
    """
    rings = [_ring(level.outline, away) for level in levels]
    knots: list[tuple[float, np.ndarray]] = [(levels[0].low, rings[0])]
    for (lower, below), (upper, above) in itertools.pairwise(zip(levels, rings, strict=True)):
        both = _ring(convex_hull(np.concatenate([lower.outline, upper.outline])), away)
        knots += _sampled_in(lower, below, both, -1.0)
        knots.append((upper.low, both))
        knots += _sampled_in(upper, above, both, 1.0)
    knots.append((levels[-1].high, rings[-1]))
    waves = np.column_stack([
        rng.integers(3, 15, _WAVES) * rng.choice([-1, 1], _WAVES),
        rng.uniform(0.6, 3.5, _WAVES),
        rng.uniform(0.0, 2 * np.pi, _WAVES),
        (0.0006 + 0.0022 * slack) * rng.uniform(0.5, 1.0, _WAVES),
    ])  # fmt: skip
    return FilmSkin(np.array([height for height, _ in knots]), np.array([ring for _, ring in knots]), waves)


def _sampled_in(level: Level, own: np.ndarray, common: np.ndarray, sign: float) -> list[tuple[float, np.ndarray]]:
    """Return the ring where film that leaves the ``common`` outline at an edge of ``level`` has reached its ``own``."""
    gap = float(np.linalg.norm(own - common, axis=1).max())
    if gap < _SAME:
        return []
    rise = min(_SAMPLED_IN * gap, 0.45 * (level.high - level.low))
    return [(level.low + rise if sign > 0 else level.high - rise, own)]


def _ring(outline: Float[np.ndarray, "n 2"], away: float) -> Float[np.ndarray, "columns 2"]:
    """Return ``COLUMNS`` points around a convex outline, ``away`` (m) from it; every tenth is one of its corners."""
    wide = grown(_simplified(outline), away)
    spans = np.ptp(wide, axis=0)
    first = [int(np.argmax((wide / spans) @ corner)) for corner in _CORNERS]
    ring = []
    for start, end in zip(first, [*first[1:], first[0]], strict=True):
        count = (end - start) % len(wide) if end != start else 0
        ring.append(_side(wide[(start + np.arange(count + 1)) % len(wide)]))
    points = np.concatenate(ring)
    corners = points[::_SIDE]
    points[::_SIDE] = corners + _BLUNT * away * -_CORNERS
    return points


def _side(path: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "side 2"]:
    """Return the columns along a side from one corner of the load to before the next; every bend of it gets one."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    if lengths[-1] < 1e-9:
        return np.repeat(path[:1], _SIDE, axis=0)
    at = _ALONG * lengths[-1]
    for bend in lengths[1:-1]:
        at[1 + np.argmin(np.abs(at[1:] - bend))] = bend
    return np.column_stack([np.interp(at, lengths, path[:, axis]) for axis in (0, 1)])


def _simplified(outline: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "m 2"]:
    """Return the outline without corners that stand out by less than 2 mm; at least four are left.

    The flattest goes first. Only its neighbours then stand out by another height, so one height is computed a corner
    and two a step: numpy would take longer to begin than all of them take.
    """
    points: list[list[float]] = outline.tolist()
    heights = [_height(points, index) for index in range(len(points))]
    while len(points) > 4:
        flattest = heights.index(least := min(heights))
        if least > _FLAT:
            break
        del points[flattest], heights[flattest]
        for index in (flattest - 1, flattest % len(points)):
            heights[index] = _height(points, index)
    return np.array(points)


def _height(points: list[list[float]], index: int) -> float:
    """Return how far a corner stands out from the chord of its neighbours (m); none without a chord."""
    (x, y), (x_before, y_before), (x_after, y_after) = (
        points[index],
        points[index - 1],
        points[(index + 1) % len(points)],
    )
    chord_x, chord_y = x_after - x_before, y_after - y_before
    length = math.sqrt(chord_x * chord_x + chord_y * chord_y)
    return abs(chord_x * (y - y_before) - chord_y * (x - x_before)) / length if length else 0.0


@dataclass(frozen=True, eq=False)
class Sheet:
    """What lies between a lower (or left) line and an upper (or right) one, point by point."""

    column: Float[np.ndarray, "2 n"]
    """Columns of the points of both lines."""
    height: Float[np.ndarray, "2 n"]
    """Heights of them (m)."""
    proud: float = 0.0
    """How far the sheet stands over the skin (m)."""
    wide: Bool[np.ndarray, " n"] | None = None
    """Where the lines are apart; what lies between two places that are not wide is left out. None: everywhere."""


def laid_on(skin: FilmSkin, sheets: Mapping[str, Sequence[Sheet]]) -> dict[str, TriangleMesh]:
    """Return one mesh for each material of ``sheets``: the sheets after one another, each with its lower line first."""
    every = [sheet for group in sheets.values() for sheet in group]
    proud = np.repeat([sheet.proud for sheet in every], [sheet.column.size for sheet in every])
    points = skin.points(
        np.concatenate([sheet.column.ravel() for sheet in every]),
        np.concatenate([sheet.height.ravel() for sheet in every]),
        proud,
    )
    found, first = dict[str, TriangleMesh](), 0
    for material, group in sheets.items():
        starts = np.cumsum([0, *(sheet.column.size for sheet in group)])
        faces = [band_faces(sheet.column.shape[1], sheet.wide) + at for sheet, at in zip(group, starts, strict=False)]
        vertices = points[first : first + starts[-1]]
        found[material] = TriangleMesh(vertices, np.concatenate([np.empty((0, 3), int), *faces]).astype(np.int32))
        first += int(starts[-1])
    return found


def band_faces(count: int, wide: Bool[np.ndarray, " n"] | None = None) -> Int[np.ndarray, "m 3"]:
    """Return the faces of a sheet whose lines have ``count`` points, but for those between two not ``wide`` ones."""
    keep = np.ones(count - 1, bool) if wide is None else wide[:-1] | wide[1:]
    i = np.arange(count - 1, dtype=np.int32)[keep]
    return np.concatenate([np.stack([i, i + 1, i + 1 + count], -1), np.stack([i, i + 1 + count, i + count], -1)])
