"""Which boxes overlap, and how far apart two are, or how deep one is in the other.

Axis-parallel ones by sort and sweep, whose cost grows with the answer and not with all pairs; pairs of others by the
separating axis test.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import OrientedBox

_FEW = 8192
"""Up to so many pairs are compared one by one: that is faster than sorting."""
_MOST_STRIPS = 64
"""Strips that a scene is cut into at most."""


def overlapping_pairs(
    low_a: Float[np.ndarray, "n 3"],
    high_a: Float[np.ndarray, "n 3"],
    low_b: Float[np.ndarray, "m 3"],
    high_b: Float[np.ndarray, "m 3"],
) -> Int[np.ndarray, "k 2"]:
    """Return the index pairs (a, b) of boxes that overlap or touch, in rising order.

    Two intervals overlap when one of them begins inside the other. Sorting the beginnings along one axis gives these
    pairs as ranges (Cohen et al. 1995, I-COLLIDE, section 3, for one sweep). A hall is cut into strips along a second
    axis, each swept alone, as most of what is level with a box on one axis is far from it on the other.

    Args:
        low_a: Lower corners of the first set (m).
        high_a: Upper corners of the first set (m).
        low_b: Lower corners of the second set (m).
        high_b: Upper corners of the second set (m).
    """
    if not len(low_a) or not len(low_b):
        return np.empty((0, 2), dtype=np.int64)
    if len(low_a) * len(low_b) <= _FEW:
        return _compared(low_a, high_a, low_b, high_b)
    spread = np.std(np.concatenate([low_a, high_a, low_b, high_b]), axis=0)
    across, along = (int(axis) for axis in np.argsort(spread, kind="stable")[1:])
    pairs = _swept(low_a, high_a, low_b, high_b, along, across)
    for other in (other for other in range(3) if other != along):
        a, b = pairs[:, 0], pairs[:, 1]
        pairs = pairs[(low_a[a, other] <= high_b[b, other]) & (low_b[b, other] <= high_a[a, other])]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _compared(low_a: np.ndarray, high_a: np.ndarray, low_b: np.ndarray, high_b: np.ndarray) -> Int[np.ndarray, "k 2"]:
    """Return the pairs that overlap on all axes, each pair looked at."""
    meet = np.ones((len(low_a), len(low_b)), bool)
    for axis in range(3):
        meet &= low_a[:, None, axis] <= high_b[:, axis]
        meet &= low_b[:, axis] <= high_a[:, None, axis]
    return np.argwhere(meet)


def _swept(
    low_a: np.ndarray, high_a: np.ndarray, low_b: np.ndarray, high_b: np.ndarray, along: int, across: int
) -> Int[np.ndarray, "k 2"]:
    """Return the pairs that overlap on the axis ``along`` and share a strip of the axis ``across``, once each."""
    box_a, strip_a, first_a = _strips(low_a[:, across], high_a[:, across], low_b[:, across], high_b[:, across])
    box_b, strip_b, first_b = _strips(low_b[:, across], high_b[:, across], low_a[:, across], high_a[:, across])
    # Ranks compare as the lengths do, and one strip after the other makes one long line of all of them.
    values, rank = np.unique(
        np.concatenate([low_a[:, along], high_a[:, along], low_b[:, along], high_b[:, along]]), return_inverse=True
    )
    begin_a, end_a, begin_b, end_b = np.split(rank, np.cumsum([len(low_a), len(low_a), len(low_b)]))
    line_a, line_b = strip_a * len(values), strip_b * len(values)
    forth = _begins_inside(begin_a[box_a] + line_a, end_a[box_a] + line_a, begin_b[box_b] + line_b, ties=True)
    back = _begins_inside(begin_b[box_b] + line_b, end_b[box_b] + line_b, begin_a[box_a] + line_a, ties=False)
    a, b = np.concatenate([forth, back[:, ::-1]]).T
    # Two boxes share every strip from the one in which the later of them begins.
    first = strip_a[a] == np.maximum(first_a[box_a[a]], first_b[box_b[b]])
    return np.column_stack([box_a[a[first]], box_b[b[first]]])


def _strips(
    low: np.ndarray, high: np.ndarray, other_low: np.ndarray, other_high: np.ndarray
) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"], Int[np.ndarray, " n"]]:
    """Return box and strip of each strip that an interval reaches into, and the first strip of each interval.

    The strips are the same for the intervals and the ``other`` ones, at least twice as wide as these are on average.
    """
    start = min(low.min(), other_low.min())
    room = max(high.max(), other_high.max()) - start
    mean = (np.sum(high - low) + np.sum(other_high - other_low)) / (len(low) + len(other_low))
    width = max(room / _MOST_STRIPS, 2.0 * mean, 1e-9)
    first = ((low - start) // width).astype(np.int64)
    count = np.maximum(((high - start) // width).astype(np.int64) - first, 0) + 1
    box = np.repeat(np.arange(len(low)), count)
    strip = np.arange(len(box)) - np.repeat(np.cumsum(count) - count - first, count)
    return box, strip, first


def _begins_inside(
    low: Int[np.ndarray, " n"], high: Int[np.ndarray, " n"], begin: Int[np.ndarray, " m"], ties: bool
) -> Int[np.ndarray, "k 2"]:
    """Return pairs (interval, other) where the other begins inside the interval; ``ties`` counts equal beginnings."""
    order = np.argsort(begin, kind="stable")
    first = np.searchsorted(begin[order], low, side="left" if ties else "right")
    last = np.searchsorted(begin[order], high, side="right")
    count = np.maximum(last - first, 0)
    interval = np.repeat(np.arange(len(low)), count)
    within = np.arange(len(interval)) - np.repeat(np.cumsum(count) - count, count)
    return np.stack([interval, order[first[interval] + within]], axis=1)


@dataclass(frozen=True, eq=False)
class Separation:
    """Result of the test for n pairs of boxes."""

    distance: Float[np.ndarray, " n"]
    """Gap along the best axis (m), a lower bound of the true distance; negative = depth of the overlap."""
    axis: Float[np.ndarray, "n 3"]
    """That axis in the common frame, unit, pointing from the first box to the second."""


@dataclass(frozen=True, eq=False)
class BoxStack:
    """Boxes of one frame as arrays."""

    centre: Float[np.ndarray, "n 3"]
    """Positions (m)."""
    rotation: Float[np.ndarray, "n 3 3"]
    """Orientations."""
    half: Float[np.ndarray, "n 3"]
    """Half the edge lengths (m)."""

    @classmethod
    def of(cls, boxes: Sequence[OrientedBox]) -> "BoxStack":
        """Stack ``boxes``, which may be none; their parent frame becomes the common frame."""
        T = np.array([box.T_parent_box for box in boxes]).reshape(-1, 4, 4)
        sizes = np.array([box.size for box in boxes], dtype=float).reshape(-1, 3)
        return cls(T[:, :3, 3], T[:, :3, :3], sizes / 2.0)

    def subset(self, chosen: Bool[np.ndarray, " n"]) -> "BoxStack":
        """Return the boxes for which ``chosen`` is set."""
        return BoxStack(self.centre[chosen], self.rotation[chosen], self.half[chosen])

    def distances_to(self, point: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " n"]:
        """Return the distance (m) from ``point`` to each box, 0 inside."""
        local = np.einsum("nij,ni->nj", self.rotation, point - self.centre)
        return np.linalg.norm(np.maximum(np.abs(local) - self.half, 0.0), axis=1)

    def block(self, eye: Float[np.ndarray, " 3"], points: Float[np.ndarray, "m 3"]) -> Bool[np.ndarray, " m"]:
        """Return for each point whether a box lies across the line from ``eye`` to it (slab test)."""
        start = np.einsum("nij,ni->nj", self.rotation, eye - self.centre)[:, None]
        step = np.einsum("nij,nmi->nmj", self.rotation, np.broadcast_to(points - eye, (len(self.half), *points.shape)))
        with np.errstate(divide="ignore", invalid="ignore"):
            one, two = (-self.half[:, None] - start) / step, (self.half[:, None] - start) / step
        # A line parallel to a slab and inside it has one = -inf, two = inf; outside it both have the same sign.
        enter = np.nanmax(np.minimum(one, two), axis=2)
        leave = np.nanmin(np.maximum(one, two), axis=2)
        return np.any((enter < leave) & (leave > 0.0) & (enter < 1.0), axis=0)

    def extents(self) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
        """Return the lower and upper corners (m) of the axis-parallel boxes around each box."""
        return self._extents

    @cached_property
    def _extents(self) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
        reach = np.einsum("nij,nj->ni", np.abs(self.rotation), self.half)
        return self.centre - reach, self.centre + reach

    def near(self, low: Float[np.ndarray, " 3"], high: Float[np.ndarray, " 3"]) -> Bool[np.ndarray, " n"]:
        """Return of each box whether the axis-parallel box around it meets that from ``low`` to ``high`` (m)."""
        lows, highs = self.extents()
        meet = np.ones(len(lows), bool)
        for axis in range(3):
            meet &= (lows[:, axis] <= high[axis]) & (highs[:, axis] >= low[axis])
        return meet

    def pairs(self, other: "BoxStack", margin: float = 0.0) -> Int[np.ndarray, "k 2"]:
        """Return index pairs (self, other) whose axis-parallel boxes come within ``margin`` (m) of each other."""
        (low_a, high_a), (low_b, high_b) = self.extents(), other.extents()
        return overlapping_pairs(low_a - margin, high_a + margin, low_b, high_b)

    def clear_of(self, box: OrientedBox, clearance: float) -> bool:
        """Return whether every box of the stack is at least ``clearance`` (m) away from ``box``."""
        single = BoxStack.of([box])
        pairs = self.pairs(single, clearance)
        return bool(len(pairs) == 0 or self.separation(single, pairs).distance.min() >= clearance)

    def separation(self, other: "BoxStack", pairs: Int[np.ndarray, "k 2"]) -> Separation:
        """Test pairs of boxes over their 15 candidate axes (Gottschalk, Lin and Manocha 1996, section 5)."""
        a, b = pairs[:, 0], pairs[:, 1]
        R_a, R_b = self.rotation[a], other.rotation[b]
        between = other.centre[b] - self.centre[a]
        edges = np.cross(R_a[:, :, :, None], R_b[:, :, None, :], axis=1).reshape(len(pairs), 3, 9)
        axes = np.concatenate([R_a, R_b, edges], axis=2)
        length = np.linalg.norm(axes, axis=1)
        usable = length > 1e-6  # parallel edges span no axis of their own
        axes = axes / np.where(usable, length, 1.0)[:, None, :]
        reach = _reach(axes, R_a, self.half[a]) + _reach(axes, R_b, other.half[b])
        along = np.einsum("kij,ki->kj", axes, between)
        gaps = np.where(usable, np.abs(along) - reach, -np.inf)
        best = np.argmax(gaps, axis=1)
        rows = np.arange(len(pairs))
        sign = np.where(along[rows, best] < 0.0, -1.0, 1.0)
        return Separation(gaps[rows, best], axes[rows, :, best] * sign[:, None])


def _reach(
    axes: Float[np.ndarray, "k 3 j"], rotation: Float[np.ndarray, "k 3 3"], half: Float[np.ndarray, "k 3"]
) -> Float[np.ndarray, "k j"]:
    """Return half the width of each box's shadow on each axis (m)."""
    cosines = np.abs(np.einsum("kij,kil->kjl", axes, rotation))
    return np.einsum("kjl,kl->kj", cosines, half)
