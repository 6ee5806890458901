"""``detect-keypoints``: key points of pallet faces in boxes, and poses by perspective-n-point.

Depth is optional: where it is measured, it says better how far the face is and how it is turned.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import LeastVisible, PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import described
from warehouse_sim.estimators.segmenters.segnet.estimator import TrainedSegmenter, detection_edges
from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points
from warehouse_sim.schema import PoseEstimate

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
    cost_px: float
    """Weighted mean distance of the points (px), with what gravity and depth say against it."""
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
        poses.append(FacePose(T, obj_id, error + _against(T, ahead, gravity, distance), points[:4]))
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


_ERROR_PX = 4.0
"""Error at which trust falls to 1/e."""


class KeypointEstimator(PoseEstimator):
    """The key points of a run folder as a pose estimator.

    Args:
        run: Run folder, or folder of a bundled model.
        use_depth: Whether depth, where there is any, decides between near and far, and places and turns the face.

    Raises:
        TrainingError: The folder holds no complete run.
        InputError: The run was trained without key points.
    """

    min_visible = LeastVisible(0.25, 64)

    def __init__(self, run: Path, use_depth: bool = True) -> None:
        self._network, self._use_depth = TrainedSegmenter(run), use_depth
        if not self._network.run_config.objects:
            raise InputError(f"{run} was trained without key points; train keypoints-rgb")

    @property
    def objects(self) -> tuple[KnownFaces, ...]:
        """What it knows."""
        return self._network.run_config.objects

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return self._network.reads_rgb

    @property
    def reads_depth(self) -> bool:
        """Whether images need depth, which else is taken where it is there."""
        return self._network.reads_depth

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a pose for each detection whose face shows four points at least.

        Raises:
            InputError: The image lacks colour.
        """
        if not image.detections:
            return []
        started = time.perf_counter()
        seen = self._network.look(image, [detection_edges(item) for item in image.detections])
        poses = list[tuple[int, FacePose]]()
        for position, item in enumerate(image.detections):
            points = SeenPoints(*seen.points(position))
            distance = self._distance(image, item, seen.probability[position]) if self._use_depth else None
            pose = pose_of_points(points, self._may_be(item), image.camera, image.gravity, distance)
            if pose is not None:
                poses.append((position, moved_onto_face(pose, image) if self._use_depth else pose))
        seconds = time.perf_counter() - started
        estimates = list[PoseEstimate]()
        for position, pose in poses:
            trust = float(np.exp(-pose.cost_px / _ERROR_PX))
            place = image, position, pose.obj_id
            estimates.append(described(*place, self.objects, trust, pose.T_camera_object, seconds))
        return estimates

    def _may_be(self, item: Detection) -> Sequence[KnownFaces]:
        requested = item.may_be if item.model is None else (item.model,)
        if requested:
            return [shape for shape in self.objects if shape.obj_id in requested or shape.name in requested]
        return [shape for shape in self.objects if item.class_name in ("", shape.class_name)]

    def _distance(self, image: RgbdImage, item: Detection, probability: np.ndarray) -> float | None:
        """Return the median depth (m) of what is likely the object in the middle of its box; None without readings."""
        left, top, right, bottom = (round(edge) for edge in detection_edges(item))
        part = image.depth[max(0, top) : max(0, bottom), max(0, left) : max(0, right)]
        valid = part[part > 0]
        return float(np.median(valid)) if valid.size else None
