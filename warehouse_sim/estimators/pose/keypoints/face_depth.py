"""Where depth is measured, it says better than key points how far a face is and how it is turned."""

from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.keypoints.pnp import FacePose
from warehouse_sim.geometry.pose import make_transform, transform_points

_FEWEST = 30
"""Readings on a face from which it is measured."""
_SAME_PLANE = 0.04
"""Readings of a face differ in distance by no more than this fraction, once its slope is taken away."""
_LEAST_FRACTION = 0.2
"""Of the readings in the face's outline that lie on it: pockets show what is behind, occluders what is before."""
_RANGE = (0.5, 2.0)
"""How wrong the distance by key points can be."""
_FARTHEST_TURN = np.radians(30.0)
"""A plane that is turned by more against the key points is another one."""
_ROUNDS = 4
_LEAST_BAND = 0.01
"""Readings nearer than this to the plane (m) are never left out."""


def moved_onto_face(pose: FacePose, image: RgbdImage) -> FacePose:
    """Return the pose on the plane that the face's readings lie in: upright where gravity is known, turned, and moved.

    The face's middle stays on its ray, so that the key points still are where they were seen. Of the readings inside
    the face's outline those count that most others are as far as, seen from the face that key points tell; where
    these are few, or lie in another plane, the pose stays.

    Args:
        pose: By key points.
        image: With depth (m); pixels of 0 are not measured.
    """
    corners = transform_points(pose.T_camera_object, pose.face)
    points = _readings(corners, image)
    if points is None:
        return pose
    middle = corners.mean(axis=0)
    T, inwards = pose.T_camera_object, _inwards(corners)
    normal = _plane(points, inwards)
    turn = np.eye(3)
    if image.gravity is not None:
        turn = _shortest(T[:3, 2], -image.gravity)
        normal = _across(normal, image.gravity)
    further = _shortest(turn @ inwards, normal)
    if np.trace(further) < 1.0 + 2.0 * np.cos(_FARTHEST_TURN):
        return pose
    turn = further @ turn
    farther = float(np.median(points @ normal) / (middle @ normal))
    if not _RANGE[0] < farther < _RANGE[1]:  # A plane along the line of sight meets it anywhere.
        return pose
    moved = middle * farther
    return replace(pose, T_camera_object=make_transform(turn @ T[:3, :3], moved + turn @ (T[:3, 3] - middle)))


def _readings(corners: Float[np.ndarray, "4 3"], image: RgbdImage) -> Float[np.ndarray, "n 3"] | None:
    """Return the points (m, camera frame) that are measured on a face; None where they are too few."""
    outline = np.zeros(image.depth.shape, dtype=np.uint8)
    cv2.fillConvexPoly(outline, np.round(image.camera.project(corners)).astype(np.int32), 1)
    v, u = np.nonzero((outline > 0) & (image.depth > 0))
    if len(v) < _FEWEST:
        return None
    rays, normal = image.camera.rays_at(u, v), _inwards(corners)
    depth = image.depth[v, u].astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = depth * (rays @ normal) / (corners[0] @ normal)
    possible = (fraction > _RANGE[0]) & (fraction < _RANGE[1])
    points, fraction = (rays * depth[:, None])[possible], fraction[possible]
    ordered = np.sort(fraction)
    alike = np.searchsorted(ordered, ordered * (1.0 + _SAME_PLANE), side="right") - np.arange(len(ordered))
    if len(ordered) < _FEWEST or alike.max() < max(_FEWEST, _LEAST_FRACTION * len(ordered)):
        return None
    nearest = ordered[int(alike.argmax())]
    return points[(fraction >= nearest) & (fraction <= nearest * (1.0 + _SAME_PLANE))]


def _inwards(corners: Float[np.ndarray, "4 3"]) -> Float[np.ndarray, " 3"]:
    """Return the normal of a face that points into the object; corners from the top left on, clockwise as seen."""
    normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    return normal / np.linalg.norm(normal)


def _shortest(start: Float[np.ndarray, " 3"], end: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """Return the shortest turn from one direction to another."""
    axis = np.cross(start, end)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        return np.eye(3)
    return np.asarray(cv2.Rodrigues(axis / sine * np.arctan2(sine, start @ end))[0])


def _across(direction: Float[np.ndarray, " 3"], axis: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " 3"]:
    """Return the part of a direction at right angles to an axis, of length one."""
    part = direction - (direction @ axis) * axis
    return part / np.linalg.norm(part)


def _plane(points: Float[np.ndarray, "n 3"], like: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " 3"]:
    """Return the normal of the plane of most points, on the side of a direction: least squares, trimmed."""
    kept, normal = points, like
    for _ in range(_ROUNDS):
        middle = np.median(kept, axis=0) if kept is points else kept.mean(axis=0)
        normal = np.linalg.svd(kept - middle, full_matrices=False)[2][2]
        apart = np.abs((points - middle) @ normal)
        kept = points[apart <= max(_LEAST_BAND, 3.0 * float(np.median(apart)))]
    return normal if normal @ like >= 0 else -normal
