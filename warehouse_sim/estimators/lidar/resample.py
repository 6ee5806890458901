"""A cloud of any size as a fixed number of points: K-means or farthest points of many, random repeats of few."""

from typing import Literal

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import cKDTree

Resampling = Literal["kmeans", "farthest", "random"]
_MOST_A_CENTRE = 8
"""Of larger clouds so many points for each centre decide where the centres lie."""
_MOST_A_POINT = 32
"""Of larger clouds so many points for each that is wanted may be taken."""


def resample(
    points: Float[np.ndarray, "n 3"], count: int, method: Resampling, rng: np.random.Generator
) -> Float[np.ndarray, "count 3"]:
    """Return exactly ``count`` points of a cloud, in random order.

    Args:
        points: At least one (m).
        count: How many are wanted.
        method: What is done with more points than that; with fewer, all are kept and some repeated.
        rng: Source of randomness.
    """
    if not len(points):
        raise ValueError("a cloud without points cannot be resampled")
    if len(points) <= count:
        return points[rng.permutation(fill_up(len(points), count, rng))]
    if method == "kmeans":
        return kmeans_centres(points, count, rng)[rng.permutation(count)]
    if method == "farthest":
        return points[rng.permutation(farthest_points(points, count, rng))]
    return points[rng.permutation(len(points))[:count]]


def fill_up(present: int, count: int, rng: np.random.Generator) -> Int[np.ndarray, " count"]:
    """Return numbers below ``present``, each once, and random ones with replacement up to ``count``."""
    return np.concatenate([np.arange(present), rng.integers(present, size=count - present)])


def kmeans_centres(
    points: Float[np.ndarray, "n 3"], count: int, rng: np.random.Generator, steps: int = 10
) -> Float[np.ndarray, "count 3"]:
    """Return the centres of exactly ``count`` clusters (Lloyd 1982), none of which is empty.

    Centres of curved or bent surfaces lie beside them: ``farthest_points`` returns points that were measured.

    Args:
        points: More than ``count`` (m).
        count: Of the centres.
        rng: Decides where they start, and which points of a large cloud decide.
        steps: Most steps; fewer where nothing moves any more.
    """
    if len(points) > _MOST_A_CENTRE * count:
        points = points[rng.permutation(len(points))[: _MOST_A_CENTRE * count]]
    centres = np.asarray(points[rng.permutation(len(points))[:count]], dtype=float)
    for _ in range(steps):
        distance, owner = cKDTree(centres).query(points)
        size = np.bincount(owner, minlength=count)
        sums = np.stack([np.bincount(owner, points[:, axis], count) for axis in range(3)], axis=1)
        moved = sums / np.maximum(size, 1)[:, None]
        empty = np.flatnonzero(size == 0)
        # Where two centres began at one place, one of them goes to the point that is worst off.
        moved[empty] = points[np.argsort(-distance)[: len(empty)]]
        still = np.abs(moved - centres).max() < 1e-6
        centres = moved
        if still:
            break
    return centres


def farthest_points(
    points: Float[np.ndarray, "n 3"], count: int, rng: np.random.Generator
) -> Int[np.ndarray, " count"]:
    """Return the numbers of points each of which is farthest from those before it (Gonzalez 1985), from a random one.

    Args:
        points: At least ``count`` (m).
        count: How many are wanted.
        rng: Decides which is the first, and which points of a large cloud may be taken.
    """
    allowed = np.arange(len(points))
    if len(points) > _MOST_A_POINT * count:
        allowed = rng.permutation(len(points))[: _MOST_A_POINT * count]
    cloud = np.ascontiguousarray((points[allowed] - points[allowed[0]]).T, dtype=np.float32)
    x, y, z = cloud
    taken, nearest = np.empty(count, np.int64), np.full(len(allowed), np.inf, np.float32)
    taken[0] = rng.integers(len(allowed))
    for step in range(1, count):
        last = taken[step - 1]
        distance = np.square(x - x[last]) + np.square(y - y[last]) + np.square(z - z[last])
        np.minimum(nearest, distance, out=nearest)
        nearest[last] = -1.0
        taken[step] = nearest.argmax()
    return np.asarray(allowed[taken])
