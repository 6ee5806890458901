"""The floor of a sweep, and how high above it its points are."""

import numpy as np
from jaxtyping import Float

_TRIED = 3000
"""Points that the search looks at."""
_ROUNDS = 200
_MOST_SLOPE = 0.1
"""A steeper plane (rad, nearly) against the LiDAR's own horizon is no floor."""
_FARTHEST = 20.0
_LEAST_FRACTION = 0.05
Plane = Float[np.ndarray, " 3"]
"""Slopes a, b and height c (m) of z = a x + b y + c in the LiDAR frame."""


def floor_of(points: Float[np.ndarray, "n 3"], rng: np.random.Generator) -> Plane | None:
    """Return the plane of most points among those that nearly lie level and that nothing much lies under.

    Sampled triples (RANSAC, Fischler and Bolles 1981), then least squares. None where no floor is seen.

    Args:
        points: LiDAR frame (m), z about upwards.
        rng: Source of randomness.
    """
    points = np.asarray(points, dtype=float)
    near = points[(np.hypot(points[:, 0], points[:, 1]) < _FARTHEST) & (points[:, 2] < 0.0)]
    if len(near) < 100:
        return None
    tried = near[rng.choice(len(near), min(len(near), _TRIED), replace=False)]
    tolerance = 0.02 + 0.003 * np.linalg.norm(tried, axis=1)
    best, most = None, _LEAST_FRACTION
    for _ in range(_ROUNDS):
        three = tried[rng.choice(len(tried), 3, replace=False)]
        try:
            plane = np.linalg.solve(np.column_stack([three[:, :2], np.ones(3)]), three[:, 2])
        except np.linalg.LinAlgError:
            continue
        above = above_floor(tried, plane)
        on = float((np.abs(above) <= tolerance).mean())
        if np.abs(plane[:2]).max() <= _MOST_SLOPE and on > most and (above < -3.0 * tolerance).mean() < 0.02:
            best, most = plane, on
    return None if best is None else _fitted(near, best)


def above_floor(points: Float[np.ndarray, "n 3"], plane: Plane) -> Float[np.ndarray, " n"]:
    """Return the distance (m) of points (LiDAR frame) to a plane, positive above it."""
    height = points[:, 2] - points[:, :2] @ plane[:2] - plane[2]
    return np.asarray(height / np.sqrt(1.0 + plane[:2] @ plane[:2]))


def up_of(plane: Plane) -> Float[np.ndarray, " 3"]:
    """Return the unit normal of a plane that points up (LiDAR frame)."""
    normal = np.array([-plane[0], -plane[1], 1.0])
    return normal / np.linalg.norm(normal)


def _fitted(points: Float[np.ndarray, "n 3"], plane: Plane) -> Plane:
    for _ in range(3):
        on = np.abs(above_floor(points, plane)) <= 0.02 + 0.003 * np.linalg.norm(points, axis=1)
        flat = points[on]
        plane = np.linalg.lstsq(np.column_stack([flat[:, :2], np.ones(len(flat))]), flat[:, 2], rcond=None)[0]
    return np.asarray(plane)
