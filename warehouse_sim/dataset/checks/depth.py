"""What depth images and points say: which is the ground truth, along which line it is measured, what is too far."""

import cv2
import numpy as np
from jaxtyping import Float, Num

from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points

NOT_ITS_GT = "is not the ground truth behind the depth that was read"
# Depth sensors err by a few per cent, at edges by more; an image of another place errs by much more.
_LARGEST_ERROR = 0.2
_ENOUGH_READINGS = 100


def matches_reading(clean: Num[np.ndarray, "h w"], read: Num[np.ndarray, "h w"]) -> bool:
    """Return whether most readings lie near the clean depth, both in the same unit, 0 = none; a few say nothing."""
    if clean.shape != read.shape:
        return False
    readings = int((read > 0).sum())
    both = (clean > 0) & (read > 0)
    if readings < _ENOUGH_READINGS:
        return True
    gt = clean[both].astype(np.float64)
    return 2 * len(gt) > readings and bool(np.median(np.abs(read[both] - gt) / gt) < _LARGEST_ERROR)


_NEARER = 0.9
"""Of a camera's range: targets whose centre is nearer show something within it."""


def may_read_nothing(subject: Subject, scene: int, observation: int) -> bool:
    """Return whether all targets of an observation are beyond the shortest range of the recipe's depth cameras."""
    ranges = subject.manifest.contents.depth_ranges.values()
    noted = subject.record(scene).observations
    if not ranges or observation >= len(noted):
        return False
    return all(item.distance > _NEARER * min(ranges) for item in noted[observation].targets)


_FEW = 200
_AGREES = 0.05
_LEAST_SPREAD = 0.02
"""Of distance over depth within the image: a narrow view cannot tell one from the other."""


def range_fraction(
    read: Float[np.ndarray, " n"], z: Float[np.ndarray, " n"], distance: Float[np.ndarray, " n"]
) -> float:
    """Return how much of the way from z-depth to distance the readings went: 0 = depth along the axis, 1 = range.

    Least squares of ``read = a z + b (distance - z)`` on what agrees with either; ``a`` takes a sensor's scale.

    Args:
        read: Depth as stored (m).
        z: True depth along the axis (m).
        distance: True distance (m).
    """
    near = np.minimum(np.abs(read - z), np.abs(read - distance)) < _AGREES * z
    ahead = distance[near] / z[near] - 1.0
    if len(ahead) < _FEW or np.ptp(ahead) < _LEAST_SPREAD:
        return 0.0
    (_, fraction), *_ = np.linalg.lstsq(
        np.stack([np.ones_like(ahead), ahead], axis=1), read[near] / z[near], rcond=None
    )
    return float(fraction)


_NEAR = 0.01
_CLOSED = np.ones((3, 3), np.uint8)


def point_depth(
    points: Float[np.ndarray, "n 3"], T_camera_object: Transform, camera: PinholeCamera
) -> Float[np.ndarray, "h w"] | None:
    """Return z-depth (m) of a surface, infinity where it is not; None if part of it is behind the camera.

    Each point fills its pixel, the nearest one wins, and gaps of a pixel are closed: right to about a pixel.

    Args:
        points: Spread over the surface (m, object frame), several for each pixel.
        T_camera_object: Its pose.
        camera: Pixel centres at integers.
    """
    placed = transform_points(T_camera_object, points)
    if placed[:, 2].min() < _NEAR:
        return None
    u, v = np.rint(camera.project(placed)).T
    inside = (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
    order = np.argsort(-placed[inside, 2])
    depth = np.full((camera.height, camera.width), np.inf, np.float32)
    # Of several numbers for one place the last one stays.
    depth[v[inside][order].astype(int), u[inside][order].astype(int)] = placed[inside, 2][order]
    amodal_mask = cv2.morphologyEx(np.isfinite(depth).astype(np.uint8), cv2.MORPH_CLOSE, _CLOSED) > 0
    # What lies behind shows through gaps between the points in front.
    nearest = cv2.erode(np.where(np.isfinite(depth), depth, np.float32(1e9)), _CLOSED, borderValue=1e9)
    return np.where(amodal_mask, nearest, np.inf).astype(np.float64)
