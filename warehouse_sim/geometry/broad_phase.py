"""Which axis-parallel boxes overlap, by sort and sweep: the cost grows with the answer, not with all pairs."""

import numpy as np
from jaxtyping import Float, Int


def overlapping_pairs(
    low_a: Float[np.ndarray, "n 3"],
    high_a: Float[np.ndarray, "n 3"],
    low_b: Float[np.ndarray, "m 3"],
    high_b: Float[np.ndarray, "m 3"],
) -> Int[np.ndarray, "k 2"]:
    """Return the index pairs (a, b) of boxes that overlap or touch, in rising order.

    Two intervals overlap when one of them begins inside the other. Sorting the beginnings along one axis gives these
    pairs as ranges; the other two axes only filter them (Cohen et al. 1995, I-COLLIDE, section 3, for one sweep).

    Args:
        low_a: Lower corners of the first set (m).
        high_a: Upper corners of the first set (m).
        low_b: Lower corners of the second set (m).
        high_b: Upper corners of the second set (m).
    """
    if not len(low_a) or not len(low_b):
        return np.empty((0, 2), dtype=np.int64)
    axis = _widest_axis(low_a, high_a, low_b, high_b)
    forth = _begins_inside(low_a[:, axis], high_a[:, axis], low_b[:, axis], ties=True)
    back = _begins_inside(low_b[:, axis], high_b[:, axis], low_a[:, axis], ties=False)[:, ::-1]
    pairs = np.concatenate([forth, back])
    for other in (other for other in range(3) if other != axis):
        a, b = pairs[:, 0], pairs[:, 1]
        pairs = pairs[(low_a[a, other] <= high_b[b, other]) & (low_b[b, other] <= high_a[a, other])]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _widest_axis(*corners: Float[np.ndarray, "_ 3"]) -> int:
    """Return the axis along which the boxes are spread most; there a sweep leaves the fewest pairs."""
    return int(np.argmax(np.std(np.concatenate(corners), axis=0)))


def _begins_inside(
    low: Float[np.ndarray, " n"], high: Float[np.ndarray, " n"], begin: Float[np.ndarray, " m"], ties: bool
) -> Int[np.ndarray, "k 2"]:
    """Return pairs (interval, other) where the other begins inside the interval; ``ties`` counts equal beginnings."""
    order = np.argsort(begin, kind="stable")
    first = np.searchsorted(begin[order], low, side="left" if ties else "right")
    last = np.searchsorted(begin[order], high, side="right")
    count = np.maximum(last - first, 0)
    interval = np.repeat(np.arange(len(low)), count)
    within = np.arange(len(interval)) - np.repeat(np.cumsum(count) - count, count)
    return np.stack([interval, order[first[interval] + within]], axis=1)
