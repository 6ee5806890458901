"""Layers of equal pieces, and the patterns in which they are palletised: column, interlock, pinwheel and split row.

Column stacks keep the full compression strength of corrugated boxes; interlocked ones lose up to half of it but bind
the load and spare the pallet up to half its bending (Virginia Tech's work on unit loads, 2017). A pattern is the cycle
of layers that repeats upwards. Cells are counted without gaps, as modular pieces touch; the gaps make a layer grow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Literal, get_args

import numpy as np
from jaxtyping import Bool, Float


@dataclass(frozen=True, eq=False)
class Layer:
    """Cells for equal pieces on a level surface, centred on the origin."""

    centres: Float[np.ndarray, "n 2"]
    """Centres of the cells (m)."""
    turned: Bool[np.ndarray, " n"]
    """Whether the piece's long edge lies along y instead of x."""

    def __len__(self) -> int:
        return len(self.centres)

    def rectangles(self, size: Float[np.ndarray, " k"]) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n 2"]]:
        """Return the lower and upper corners (m) of the pieces, whose edges along x and y are ``size[:2]`` (m)."""
        half = np.where(self.turned[:, None], size[1::-1], size[:2]) / 2
        return self.centres - half, self.centres + half

    def subset(self, chosen: np.ndarray) -> "Layer":
        """Return the cells that an index or mask array chooses."""
        return Layer(self.centres[chosen], self.turned[chosen])

    def half_turn(self) -> "Layer":
        """Return the layer turned by 180 degrees about the origin."""
        return Layer(-self.centres, self.turned)

    def mirrored(self) -> "Layer":
        """Return the layer mirrored in the plane x = 0."""
        return Layer(self.centres * [-1.0, 1.0], self.turned)


def join(layers: Sequence[Layer]) -> Layer:
    """Return one layer with the cells of all ``layers``."""
    return Layer(np.concatenate([layer.centres for layer in layers]), np.concatenate([x.turned for x in layers]))


def grid(
    size: Float[np.ndarray, " k"], counts: tuple[int, int], gap: float, turned: bool, centre: Sequence[float] = (0, 0)
) -> Layer:
    """Return ``counts`` columns and rows of cells around ``centre`` (m), ``gap`` (m) apart."""
    pitch = np.asarray(size[1::-1] if turned else size[:2]) + gap
    x, y = ((np.arange(count) - (count - 1) / 2) * step for count, step in zip(counts, pitch, strict=True))
    cells = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return Layer(cells + np.asarray(centre, dtype=float), np.full(len(cells), turned))


def how_many(edge: float, length: float) -> int:
    """Return how many pieces of ``length`` fit side by side on ``edge`` (m)."""
    return int(edge / length + 1e-6)


def carried(
    low: Float[np.ndarray, "n 2"],
    high: Float[np.ndarray, "n 2"],
    below_low: Float[np.ndarray, "m 2"],
    below_high: Float[np.ndarray, "m 2"],
) -> Float[np.ndarray, " n"]:
    """Return the fraction of each upper rectangle's area that rests on the lower ones, 0 where it would tip over.

    A piece tips when what carries it does not reach around its centre by a tenth of its edge on every side.

    Args:
        low: Lower corners of the upper rectangles (m).
        high: Upper corners of the upper rectangles (m).
        below_low: Lower corners of the rectangles below, which do not overlap (m).
        below_high: Upper corners of the rectangles below (m).
    """
    left = np.maximum(low[:, None], below_low[None])
    right = np.minimum(high[:, None], below_high[None])
    touching = np.all(right > left, axis=2)
    area = np.where(touching, np.prod(np.maximum(right - left, 0.0), axis=2), 0.0).sum(axis=1)
    first = np.where(touching[..., None], left, np.inf).min(axis=1, initial=np.inf)
    last = np.where(touching[..., None], right, -np.inf).max(axis=1, initial=-np.inf)
    middle, reach = (low + high) / 2, (high - low) / 10
    steady = np.all((first <= middle - reach) & (last >= middle + reach), axis=1)
    return np.where(steady, area / np.prod(high - low, axis=1), 0.0)


Pattern = Literal["column", "interlock", "pinwheel", "split_row"]
PATTERNS: tuple[Pattern, ...] = get_args(Pattern)
Cycle = tuple[Layer, ...]
Area = tuple[float, float]
Size = Float[np.ndarray, " k"]

_LEAST_FILL = 0.8
"""A pattern that holds less than this fraction of the column pattern's pieces is not used for their size."""
_LEAST_CARRIED = 0.5
"""Least fraction of a piece's base that the layer below must carry."""


def pattern_layers(pattern: Pattern, size: Size, area: Area, gap: float) -> Cycle:
    """Return the cycle of layers of ``pattern``, empty when pieces of this size cannot be stacked so.

    Args:
        pattern: Which pattern.
        size: Edges of a piece along x and y (m), z may follow.
        area: Edges of the surface along x and y (m); pieces stay on it, but for the gaps.
        gap: Gap between neighbours (m).
    """
    return _cycle(pattern, (float(size[0]), float(size[1])), area, gap)


def possible_patterns(size: Size, area: Area, gap: float) -> tuple[Pattern, ...]:
    """Return the patterns in which pieces of this size can be stacked, ``gap`` (m) apart, on ``area`` (m by m)."""
    return tuple(pattern for pattern in PATTERNS if pattern_layers(pattern, size, area, gap))


@cache
def _cycle(pattern: Pattern, edges: tuple[float, float], area: Area, gap: float) -> Cycle:
    size = np.array(edges)
    column = _column(size, area, gap)
    if pattern == "column" or not column:
        return column
    cycle = _BUILDERS[pattern](size, area, gap)
    enough = bool(cycle) and min(map(len, cycle)) >= max(2.0, _LEAST_FILL * len(column[0]))
    return cycle if enough and _binds(cycle, size) and _stands(cycle, size) else ()


def _column(size: Size, area: Area, gap: float) -> Cycle:
    """Return one layer all along x or all along y, whichever holds more."""
    counts = [_counts(size, area, turned) for turned in (False, True)]
    turned = int(np.prod(counts[1])) > int(np.prod(counts[0]))
    layer = grid(size, counts[turned], gap, turned)
    return (layer,) if len(layer) else ()


def _interlock(size: Size, area: Area, gap: float) -> Cycle:
    """Return two strips, pieces along x in one and along y in the other; every second layer is turned by 180 degrees.

    Where no two strips fit, a layer all along x alternates with one all along y.
    """
    strips = _strips(size, area, gap, spread=False)
    if strips is not None and len(strips) >= 0.8 * len(_column(size, area, gap)[0]):
        return strips, strips.half_turn()
    layers = [grid(size, _counts(size, area, turned), gap, turned) for turned in (False, True)]
    return (layers[0], layers[1]) if all(map(len, layers)) else ()


def _split_row(size: Size, area: Area, gap: float) -> Cycle:
    """Return two strips as in the interlock, spread to the surface's edges, so that the voids are inside."""
    strips = _strips(size, area, gap, spread=True)
    return () if strips is None else (strips, strips.half_turn())


def _pinwheel(size: Size, area: Area, gap: float) -> Cycle:
    """Return four blocks around a chimney, neighbours turned by a quarter; every second layer is mirrored."""
    (x, y), best = size[:2], None
    for a, b, c, d in product(*(range(1, how_many(max(area), min(x, y)) + 1),) * 4):
        wide, high = a * x + c * y, b * y + d * x
        fits = wide <= area[0] + 1e-6 and high <= area[1] + 1e-6
        if fits and (best is None or a * b + c * d > best[0] * best[1] + best[2] * best[3]):
            p, q = x + gap, y + gap
            if (a * p <= c * q and d * p <= b * q) or (b * q <= d * p and c * q <= a * p):
                best = (a, b, c, d)
    if best is None:
        return ()
    a, b, c, d = best
    lower_left = grid(size, (a, b), gap, turned=False)
    lower_right = grid(size, (c, d), gap, turned=True)
    straight, across = _extent(lower_left, size) + gap, _extent(lower_right, size) + gap
    # The corner of the whole is half the sum of two neighbouring blocks away from the middle.
    corner = np.array([straight[0] + across[0], straight[1] + across[1]]) / 2
    shifts = -corner + straight / 2, np.array([corner[0] - across[0] / 2, -corner[1] + across[1] / 2])
    blocks = [
        Layer(block.centres + by, block.turned) for block, by in zip((lower_left, lower_right), shifts, strict=True)
    ]
    layer = join([*blocks, *(block.half_turn() for block in blocks)])
    return layer, layer.mirrored()


def _strips(size: Size, area: Area, gap: float, *, spread: bool) -> Layer | None:
    """Return the layer of two strips, one of them turned, that holds most pieces; None when both do not fit."""
    options = [
        (along_y, turned, plan)
        for along_y, turned in product((False, True), repeat=2)
        # A strip runs along x; for strips along y all is laid out on the swapped area and swapped back.
        for plan in _strip_plans(size, area[::-1] if along_y else area, turned)
    ]
    if not options:
        return None
    along_y, turned, plan = max(options, key=lambda option: sum(columns * rows for columns, rows in option[2]))
    first, second = (grid(size, counts, gap, flag) for counts, flag in zip(plan, (turned, not turned), strict=True))
    extents = [_extent(strip, size) for strip in (first, second)]
    edge, depth = max(extents[0][0], extents[1][0]), extents[0][1] + extents[1][1] + gap
    if spread:
        edge, depth = np.maximum((edge, depth), area[::-1] if along_y else area)
        first, second = _spread(first, extents[0], edge), _spread(second, extents[1], edge)
    shifts = np.array([0.0, -(depth - extents[0][1]) / 2]), np.array([0.0, (depth - extents[1][1]) / 2])
    layer = join([Layer(strip.centres + by, strip.turned) for strip, by in zip((first, second), shifts, strict=True)])
    return Layer(layer.centres[:, ::-1], ~layer.turned) if along_y else layer


def _strip_plans(size: Size, area: Area, turned: bool) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return columns and rows of the two strips, the first with ``turned`` pieces, for every way to fill ``area``."""
    (length, width), (other_length, other_width) = (size[1::-1], size[:2]) if turned else (size[:2], size[1::-1])
    plans = []
    for rows in range(1, how_many(area[1], width) + 1):
        first = how_many(area[0], length), rows
        second = how_many(area[0], other_length), how_many(area[1] - rows * width, other_width)
        if min(*first, *second) > 0:
            plans.append((first, second))
    return plans


def _spread(strip: Layer, extent: Float[np.ndarray, " 2"], edge: float) -> Layer:
    """Return a strip whose outer faces lie at the ends of ``edge`` (m); one piece alone stays in the middle."""
    span = float(np.ptp(strip.centres[:, 0]))
    factor = (span + edge - float(extent[0])) / span if span > 0 else 1.0
    return Layer(strip.centres * [factor, 1.0], strip.turned)


def _counts(size: Size, area: Area, turned: bool) -> tuple[int, int]:
    """Return how many columns and rows fit on ``area``."""
    edges = size[1::-1] if turned else size[:2]
    return how_many(area[0], edges[0]), how_many(area[1], edges[1])


def _extent(layer: Layer, size: Size) -> Float[np.ndarray, " 2"]:
    """Return the outer edges of a layer along x and y (m)."""
    low, high = layer.rectangles(size)
    return high.max(axis=0) - low.min(axis=0)


def _binds(cycle: Cycle, size: Size) -> bool:
    """Return whether layers differ, so that pieces lie across the joints below; those of square pieces often do not."""
    lower, upper = ({tuple(row) for row in np.round(np.hstack(layer.rectangles(size)), 6)} for layer in cycle)
    return len(lower & upper) < len(upper)


def _stands(cycle: Cycle, size: Size) -> bool:
    """Return whether every piece is carried by the layer below it, whichever of the cycle that is."""
    pairs = zip(cycle, (*cycle[1:], cycle[0]), strict=True)
    return all(
        carried(*upper.rectangles(size), *lower.rectangles(size)).min() >= _LEAST_CARRIED for lower, upper in pairs
    )


_BUILDERS: dict[Pattern, Callable[[Size, Area, float], Cycle]] = {
    "interlock": _interlock,
    "pinwheel": _pinwheel,
    "split_row": _split_row,
}
