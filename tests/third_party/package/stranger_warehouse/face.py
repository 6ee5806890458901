"""A vertical plane and the rectangle on it, fitted to points of a pallet that a level camera saw."""

from dataclasses import dataclass

import numpy as np

UP = np.array([0.0, -1.0, 0.0])
"""In a level OpenCV camera, whose y axis points down."""
_TRIES, _NEAR, _TAIL = 200, 0.02, 1.0
"""Planes that are tried, distance (m) of a point that lies on one, and percent of points beyond each edge."""


@dataclass(frozen=True)
class Face:
    """A rectangle in the camera frame, one edge level."""

    centre: np.ndarray
    """Of the rectangle (m)."""
    inwards: np.ndarray
    """Level unit vector away from the camera, across the face."""
    width: float
    height: float
    """Of its edges (m)."""
    fraction: float
    """Fraction of the points that lie on it, 0-1."""


def fit_face(points: np.ndarray, rng: np.random.Generator) -> Face | None:
    """Fit the vertical plane that most points lie on, and the extent of those points.

    Args:
        points: n x 3, camera frame (m).
        rng: Chooses the pairs of points through which planes are tried.

    Returns:
        None where too few points lie on one plane.
    """
    flat = points[:, [0, 2]]
    if len(flat) < 50:
        return None
    first, second = rng.integers(0, len(flat), (2, _TRIES))
    along = flat[second] - flat[first]
    length = np.linalg.norm(along, axis=1)
    far = length > 0.05
    if not far.any():
        return None
    along, start = along[far] / length[far, None], flat[first[far]]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    sample = flat[:: max(1, len(flat) // 800)]
    distance = np.abs(sample @ across.T - (start * across).sum(axis=1))
    best = int((distance < _NEAR).sum(axis=0).argmax())
    on_plane = np.abs((flat - start[best]) @ across[best]) < _NEAR
    if on_plane.sum() < 30:
        return None
    middle = flat[on_plane].mean(axis=0)
    # The line through the points on it, in the sense of least squares.
    _, _, axes = np.linalg.svd(flat[on_plane] - middle, full_matrices=False)
    level, depth = axes[0], axes[1]
    depth = depth if depth @ middle > 0 else -depth
    places = (flat[on_plane] - middle) @ level
    low, high = np.percentile(places, [_TAIL, 100 - _TAIL])
    top, bottom = np.percentile(points[on_plane, 1], [_TAIL, 100 - _TAIL])
    on_face = middle + level * (low + high) / 2
    return Face(
        centre=np.array([on_face[0], (top + bottom) / 2, on_face[1]]),
        inwards=np.array([depth[0], 0.0, depth[1]]),
        width=float(high - low),
        height=float(bottom - top),
        fraction=float(on_plane.mean()),
    )


def pallet_pose(face: Face, size: np.ndarray) -> np.ndarray:
    """Return ``T_camera_object`` (4 x 4) of the pallet of ``size`` (m) whose face it is.

    Its origin is the middle of its box, x runs along its length and z upwards. The face is that of its length or that
    of its width, whichever is nearer to what was seen.
    """
    shows_length = abs(face.width - size[0]) < abs(face.width - size[1])
    x = np.cross(UP, face.inwards) if shows_length else face.inwards
    T = np.eye(4)
    T[:3, :3] = np.stack([x, np.cross(UP, x), UP], axis=1)
    T[:3, 3] = face.centre + face.inwards * size[1 if shows_length else 0] / 2
    return T
