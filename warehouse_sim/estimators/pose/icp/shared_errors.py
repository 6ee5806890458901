"""How many readings share one error: noise of neighbours is alike, and so are biases that bend what is flat.

Readings are put into cells of the image with equally many each. If every reading had an error of its own, the mean
residual of a cell would have 1 / n of the variance of its n readings. What it has more is the number of readings that
count as one (the design effect of cluster samples: Kish, "Survey Sampling", 1965).
"""

import numpy as np
from jaxtyping import Bool, Float, Int

_SIDE = 4
"""Cells along each axis of the image."""
_FITTED = 6
"""Degrees of freedom of a pose, which takes away that much of what the cells share."""
_LEAST = 3 * _SIDE**2
"""With fewer readings than three a cell nothing is known."""
_CLIP = 3.0
"""Residuals are cut at so many standard deviations: outliers are no noise."""


def cells_of(points: Float[np.ndarray, "b n 3"], present: Bool[np.ndarray, "b n"]) -> Int[np.ndarray, "b n"]:
    """Return the cell, 0-15, of each point of b objects; 16 where there is none.

    Args:
        points: Camera frame (m).
        present: Which rows hold a point.
    """
    z = np.maximum(points[..., 2], 1e-6)
    count = np.maximum(present.sum(axis=1, keepdims=True), 1)
    column = np.minimum(_rank(np.where(present, points[..., 0] / z, np.inf)) * _SIDE // count, _SIDE)
    # Within a column, by row: ranks of both together are ranks within, behind all columns to the left.
    order = column * points.shape[1] + _rank(np.where(present, points[..., 1] / z, np.inf))
    first = np.stack([(column < number).sum(axis=1) for number in range(_SIDE + 1)], axis=1)
    size = np.stack([(column == number).sum(axis=1) for number in range(_SIDE + 1)], axis=1)
    within = _rank(order) - np.take_along_axis(first, column, axis=1)
    row = within * _SIDE // np.maximum(np.take_along_axis(size, column, axis=1), 1)
    return np.where(present, column * _SIDE + row, _SIDE**2)


def shared(
    distance: Float[np.ndarray, "b n"], used: Bool[np.ndarray, "b n"], cells: Int[np.ndarray, "b n"]
) -> Float[np.ndarray, " b"]:
    """Return how many of the readings that are used count as one, at least 1.

    Args:
        distance: Residuals of a fitted pose (m, signed).
        used: Which readings it was fitted to.
        cells: Of ``cells_of``.
    """
    sigma = np.sqrt((np.where(used, distance, 0.0) ** 2).sum(axis=1) / np.maximum(used.sum(axis=1), 1))
    residual = np.where(used, np.clip(distance, -_CLIP * sigma[:, None], _CLIP * sigma[:, None]), 0.0)
    one_hot = (cells[..., None] == np.arange(_SIDE**2)) & used[..., None]
    count = one_hot.sum(axis=1)
    mean = np.einsum("bn,bnc->bc", residual, one_hot) / np.maximum(count, 1)
    filled = count > 0
    total = np.maximum(count.sum(axis=1), 1)
    middle = residual.sum(axis=1) / total
    between = (count * (mean - middle[:, None]) ** 2).sum(axis=1) / np.maximum(filled.sum(axis=1) - _FITTED, 1)
    within = np.where(used, (residual - middle[:, None]) ** 2, 0.0).sum(axis=1) / total
    known = (total >= _LEAST) & (filled.sum(axis=1) > _FITTED) & (within > 0.0)
    return np.where(known, np.maximum(between / np.where(known, within, 1.0), 1.0), 1.0)


def _rank(values: Float[np.ndarray, "b n"] | Int[np.ndarray, "b n"]) -> Int[np.ndarray, "b n"]:
    """Return the position of each value among those of its row, in rising order."""
    return np.argsort(np.argsort(values, axis=1, kind="stable"), axis=1, kind="stable")
