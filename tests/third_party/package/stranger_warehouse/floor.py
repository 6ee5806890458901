"""Heights above the floor in what a level camera saw."""

import numpy as np

_STEP = 0.02
"""Height of the layers (m) among which the floor is looked for."""


def points_of(depth: np.ndarray, K: np.ndarray) -> np.ndarray:
    """Return the points (h x w x 3, camera frame, m) of a depth image (h x w, m); zero where there is no reading."""
    v, u = np.indices(depth.shape)
    return np.stack([(u - K[0, 2]) / K[0, 0] * depth, (v - K[1, 2]) / K[1, 1] * depth, depth], axis=-1)


def heights(points: np.ndarray) -> np.ndarray:
    """Return the height (h x w, m) above the floor: the lowest level layer that holds a twentieth of all points.

    Where there is no reading, or no floor, it is NaN.
    """
    seen = points[..., 2] > 0
    down = points[seen][:, 1]
    result = np.full(seen.shape, np.nan)
    if len(down) < 100:
        return result
    edges = np.arange(down.min(), down.max() + 2 * _STEP, _STEP)
    counts, _ = np.histogram(down, edges)
    layers = np.flatnonzero(counts > len(down) / 20)
    if len(layers) == 0:
        return result
    inside = (down >= edges[layers[-1]]) & (down < edges[layers[-1] + 1])
    result[seen] = np.median(down[inside]) - down
    return result
