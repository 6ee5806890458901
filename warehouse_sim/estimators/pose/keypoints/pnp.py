"""Poses from key points of pallet faces: perspective-n-point for each side that a face may be, one of which fits."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points

LEAST_POINTS = 4
_FLAT = 0.01
"""Points of a plane are no farther from it (m)."""
_UPRIGHT_PX_PER_RAD = 30.0
"""What a lean costs where gravity is known: 0.1 rad as much as 3 px of every point."""
_DEPTH_PX_PER_FRACTION = 30.0
"""What a wrong distance costs where depth is known: a tenth as much as 3 px of every point."""


class SeenPoints(NamedTuple):
    """Key points of one face."""

    uv: Float[np.ndarray, "6 2"]
    """Places in the image (px)."""
    chance: Float[np.ndarray, " 6"]
    """How sure each is, 0-1."""


@dataclass(frozen=True, eq=False)
class FacePose:
    """A pose that explains key points."""

    T_camera_object: Transform
    obj_id: int
    error_px: float
    """Weighted mean distance of the points (px)."""
    cost_px: float
    """The same, with what gravity and depth say against it."""
    face: Float[np.ndarray, "4 3"]
    """Corners of the side that was seen (m, object frame): top left, top right, bottom right, bottom left."""


def pose_of_points(
    seen: SeenPoints,
    objects: Sequence[KnownFaces],
    camera: PinholeCamera,
    gravity: Float[np.ndarray, " 3"] | None = None,
    distance: float | None = None,
    least_chance: float = 0.2,
) -> FacePose | None:
    """Return the pose that explains the points best; None where fewer than four are sure.

    Args:
        seen: The points.
        objects: Which objects it may be.
        camera: Of the image.
        gravity: Down in the camera frame, if it is known: of the two poses that a plane leaves, the upright one.
        distance: Median depth (m) of the face's pixels, if it is known: a small pallet near by and a large one far
            away look alike.
        least_chance: Of the points that are taken.
    """
    found = [
        pose
        for item in objects
        for side, known in zip(item.points, item.known, strict=True)
        for pose in _side_poses(
            seen, item.obj_id, np.reshape(side, (POINTS, 3)), np.array(known), camera, gravity, distance, least_chance
        )
    ]
    return min(found, key=lambda pose: pose.cost_px, default=None)


def _side_poses(
    seen: SeenPoints,
    obj_id: int,
    points: Float[np.ndarray, "6 3"],
    known: Bool[np.ndarray, " 6"],
    camera: PinholeCamera,
    gravity: Float[np.ndarray, " 3"] | None,
    distance: float | None,
    least_chance: float,
) -> list[FacePose]:
    # Pockets that open behind the face's plane are no points of it.
    frame = _plane_frame(points)
    flat = np.abs(transform_points(frame, points)[:, 2]) < _FLAT
    taken = known & flat & (seen.chance >= least_chance)
    if taken.sum() < LEAST_POINTS:
        return []
    x, y = camera.tangents_at(*seen.uv[taken].T).T
    # A plane leaves two poses (Collins & Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014).
    object_points = transform_points(frame, points[taken])
    object_points[:, 2] = 0.0
    count, turns, shifts, _ = cv2.solvePnPGeneric(
        object_points, np.stack([x, y], axis=1), np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    poses = []
    for turn, shift in zip(turns[:count], shifts[:count], strict=True):
        R, _ = cv2.Rodrigues(turn)
        T = make_transform(R, shift[:, 0]) @ frame
        ahead = transform_points(T, points)
        if (ahead[:, 2] <= 0.05).any():
            continue
        apart = np.linalg.norm(camera.project(ahead[taken]) - seen.uv[taken], axis=1)
        error = float((apart * seen.chance[taken]).sum() / seen.chance[taken].sum())
        poses.append(FacePose(T, obj_id, error, error + _against(T, ahead, gravity, distance), points[:4]))
    return poses


def _against(
    T: Transform, ahead: Float[np.ndarray, "6 3"], gravity: Float[np.ndarray, " 3"] | None, distance: float | None
) -> float:
    """Return what gravity and depth say against a pose (px)."""
    cost = 0.0
    if gravity is not None:
        cost += _UPRIGHT_PX_PER_RAD * float(np.arccos(np.clip(-T[:3, 2] @ gravity, -1.0, 1.0)))
    if distance is not None and distance > 0:
        cost += _DEPTH_PX_PER_FRACTION * abs(float(ahead[:4, 2].mean()) / distance - 1.0)
    return cost


def _plane_frame(points: Float[np.ndarray, "6 3"]) -> Transform:
    """Return the map of a side into a plane z = 0."""
    middle = points[:4].mean(axis=0)
    across, down = points[1] - points[0], points[3] - points[0]
    x, y = across / np.linalg.norm(across), down / np.linalg.norm(down)
    R = np.stack([x, y, np.cross(x, y)])
    return make_transform(R, -R @ middle)
