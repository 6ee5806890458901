"""What upright boxes have in common: rectangles turned on the ground plane, and the heights above it."""

import numpy as np
from jaxtyping import Float

_EDGES = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))


def rectangle_corners(rectangles: Float[np.ndarray, "n 5"]) -> Float[np.ndarray, "n 4 2"]:
    """Return the corners of rectangles in the order in which the first axis turns into the second.

    Args:
        rectangles: Centre (2), length, width, and the angle (rad) from the first axis to the length, in each row.
    """
    angle = rectangles[:, 4]
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * rectangles[:, 2, None]
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=-1) * rectangles[:, 3, None]
    return np.stack([rectangles[:, :2] + a * along + b * across for a, b in _EDGES], axis=1)


def shared_areas(a: Float[np.ndarray, "n 5"], b: Float[np.ndarray, "m 5"]) -> Float[np.ndarray, "n m"]:
    """Return the areas that turned rectangles (``rectangle_corners``) have in common."""
    corners_a, corners_b = rectangle_corners(a), rectangle_corners(b)
    reach = np.hypot(a[:, 2], a[:, 3])[:, None] / 2.0 + np.hypot(b[:, 2], b[:, 3]) / 2.0
    near = np.linalg.norm(a[:, None, :2] - b[None, :, :2], axis=-1) < reach
    shared = np.zeros(near.shape)
    for row, column in np.argwhere(near):
        shared[row, column] = _area(_cut(corners_a[row], corners_b[column]))
    return shared


def _cut(polygon: Float[np.ndarray, "k 2"], by: Float[np.ndarray, "4 2"]) -> Float[np.ndarray, "k 2"]:
    """Return the part of a convex polygon inside a rectangle, side by side (Sutherland and Hodgman, CACM 1974)."""
    for start, end in zip(by, np.roll(by, -1, axis=0), strict=True):
        if len(polygon) == 0:
            break
        side = end - start
        inside = side[0] * (polygon[:, 1] - start[1]) - side[1] * (polygon[:, 0] - start[0])
        after, inside_after = np.roll(polygon, -1, axis=0), np.roll(inside, -1)
        kept = []
        for here, there, depth, depth_there in zip(polygon, after, inside, inside_after, strict=True):
            if depth >= 0.0:
                kept.append(here)
            if (depth >= 0.0) != (depth_there >= 0.0):
                kept.append(here + (there - here) * (depth / (depth - depth_there)))
        polygon = np.array(kept).reshape(-1, 2)
    return polygon


def _area(polygon: Float[np.ndarray, "k 2"]) -> float:
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
