"""Upright planes that may hold a pallet's face: lines in the view from above (RANSAC, Fischler and Bolles 1981)."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z

_PAIRS = 400
"""Lines that are tried; with two points of one face in ten pairs, all but 1e-18 of the clouds get a good one."""
_LEAST_APART = 0.15
"""Points (m) that span a line."""
_LEAST_FACING = 0.2
"""Cosine between a face's normal and the ray to it: flatter than 78 degrees nothing is seen in pockets."""
_ALIKE = (0.17, 0.08)
"""Lines within such an angle (rad) and distance (m) are the same."""
_BEFORE = 0.5
"""Price of a point before the line, where nothing of the pallet can be, against the gain of one on it."""


def face_planes(
    points: Float[np.ndarray, "n 3"], tolerance: float, most: int, rng: np.random.Generator
) -> list[Transform]:
    """Return frames ``T_upright_plane`` of upright planes that face the sensor, x inwards, best first.

    Args:
        points: In a frame with z up and the sensor at its origin (m).
        tolerance: Half the thickness of a plane (m).
        most: How many planes.
        rng: Source of randomness.
    """
    first, second = rng.integers(len(points), size=(2, _PAIRS))
    along = points[second, :2] - points[first, :2]
    length = np.linalg.norm(along, axis=1)
    apart = length >= _LEAST_APART
    along, start = along[apart] / length[apart, None], points[first[apart], :2]
    inwards = np.stack([-along[:, 1], along[:, 0]], axis=1)
    distance = (inwards * start).sum(axis=1)
    inwards, distance = inwards * np.sign(distance)[:, None], np.abs(distance)
    facing = distance / np.maximum(np.linalg.norm(start, axis=1), 1e-9) >= _LEAST_FACING
    inwards, distance = inwards[facing], distance[facing]
    behind = points[:, :2] @ inwards.T - distance
    score = (np.abs(behind) <= tolerance).sum(axis=0) - _BEFORE * (behind < -tolerance).sum(axis=0)
    found: list[Transform] = []
    for index in np.argsort(-score):
        T = _placed(points, inwards[index], distance[index], tolerance)
        if not any(_is_alike(T, other) for other in found):
            found.append(T)
        if len(found) == most:
            break
    return found


def _placed(
    points: Float[np.ndarray, "n 3"], inwards: Float[np.ndarray, " 2"], distance: float, tolerance: float
) -> Transform:
    """Return the frame at the middle of the points that are on the plane, after a robust fit of its line."""
    for _ in range(4):
        along = np.array([-inwards[1], inwards[0]])
        behind, aside = points[:, :2] @ inwards - distance, points[:, :2] @ along
        weight = (np.abs(behind) <= 2.0 * tolerance) / (1.0 + (behind / tolerance * 2.0) ** 2)
        mean = (weight * aside).sum() / weight.sum()
        centred = aside - mean
        slope = (weight * centred * behind).sum() / max((weight * centred**2).sum(), 1e-9)
        offset = (weight * behind).sum() / weight.sum()
        place = inwards * (distance + offset) + along * mean
        inwards = inwards - slope * along
        inwards /= np.linalg.norm(inwards)
        distance = float(inwards @ place)
    on = np.abs(points[:, :2] @ inwards - distance) <= tolerance
    height = float(np.median(points[on, 2])) if on.any() else 0.0
    return make_transform(rotation_z(float(np.arctan2(inwards[1], inwards[0]))), np.array([*place, height]))


def _is_alike(T: Transform, other: Transform) -> bool:
    cosine = float(T[:2, 0] @ other[:2, 0])
    away = abs(float(other[:2, 0] @ (T[:2, 3] - other[:2, 3])))
    return cosine >= np.cos(_ALIKE[0]) and away <= _ALIKE[1]
