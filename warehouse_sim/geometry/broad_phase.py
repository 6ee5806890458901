"""Which axis-parallel boxes overlap, by sort and sweep: the cost grows with the answer, not with all pairs."""

import numpy as np
from jaxtyping import Float, Int

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
