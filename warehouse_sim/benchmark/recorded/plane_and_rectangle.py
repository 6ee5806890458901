"""The baseline for pallet faces: the plane that most pixels are on, and the middle of their rectangle.

Nothing of it is taken from an estimator of the package. It knows neither pockets nor posts: the fork goes to the middle
of the rectangle about what is on the plane.
"""

import numpy as np
from jaxtyping import Bool, Float

_THICK = 0.04
"""Half the thickness of the plane (m)."""


def dock_of(
    points: Float[np.ndarray, "n 3"], down: Float[np.ndarray, " 3"] | None, rng: np.random.Generator
) -> Float[np.ndarray, "4 4"]:
    """Return ``T_camera_dock`` of the largest plane of a detection's points (camera frame, m).

    Args:
        points: What is read in the detection.
        down: Gravity (camera frame), which the plane then contains; None fits all three numbers of the plane.
        rng: Source of randomness.
    """
    best: Bool[np.ndarray, " n"] = np.zeros(len(points), dtype=bool)
    for _ in range(300):
        a, b, c = points[rng.choice(len(points), 3, replace=False)]
        normal = np.cross(b - a, c - a if down is None else down)
        if np.linalg.norm(normal) < 1e-6 or abs(normal[2]) < 0.5 * np.linalg.norm(normal):
            continue
        on = np.abs((points - a) @ normal / np.linalg.norm(normal)) < _THICK
        best = on if on.sum() > best.sum() else best
    chosen = points[best]
    middle = chosen.mean(axis=0)
    if down is None:
        inwards = np.linalg.svd(chosen - middle, full_matrices=False)[2][2]
        up = np.array([0.0, -1.0, 0.0])
    else:
        up = -down / np.linalg.norm(down)
        flat = chosen - middle - np.outer((chosen - middle) @ up, up)
        inwards = np.linalg.svd(flat, full_matrices=False)[2][1]
    inwards = inwards * np.sign(inwards[2])
    left = np.cross(up, inwards)
    left /= np.linalg.norm(left)
    up = np.cross(inwards, left)
    frame = np.stack([inwards, left, up], axis=1)
    along = (chosen - middle) @ frame
    low, high = np.percentile(along, [1, 99], axis=0)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = frame, middle + frame @ np.array([0.0, *(low[1:] + high[1:]) / 2.0])
    return T
