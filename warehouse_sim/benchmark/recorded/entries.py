"""What a fork does at recorded faces when it trusts an estimate, whatever errors masks and gravity have."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.benchmark.recorded.faces import Entry, RecordedFace, drive_in
from warehouse_sim.dataset.files.image_io import decode_any_rgb
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.evaluation.docking.fork import approached_face, docking_faces
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import PoseEstimate

BASELINE = "plane and rectangle"
GRAVITY = ("none", "gt", "gt, 0.3 deg off")
MASKS = ("gt", "dilated by 5 px", "box")
_OFF_DEG = 0.3


def masked(mask: np.ndarray, kind: str, model: str | None) -> Detection:
    """Return a detection by a mask, by one that is 5 px too wide all round, or by its box."""
    if kind == "box":
        v, u = np.nonzero(mask)
        return Detection(None, model, box_xyxy=(float(u.min()), float(v.min()), float(u.max()), float(v.max())))
    if kind == "dilated by 5 px":
        mask = cv2.dilate(mask.astype(np.uint8), np.ones((11, 11), np.uint8)) > 0
    return Detection(mask, model)


def gravity_of(recorded: RecordedFace, kind: str, rng: np.random.Generator) -> np.ndarray | None:
    """Return what is known of gravity."""
    if kind == "none":
        return None
    if kind == "gt":
        return recorded.gravity
    axis = np.cross(recorded.gravity, rng.normal(size=3))
    off = recorded.gravity + np.tan(np.deg2rad(_OFF_DEG)) * np.cross(axis / np.linalg.norm(axis), recorded.gravity)
    return np.asarray(off / np.linalg.norm(off))


Answer = tuple[Transform, list[np.ndarray] | None]
"""A dock frame, and where its pockets are on it."""


def answer_of(estimate: PoseEstimate, objects: Mapping[int, ObjectInfo]) -> Answer | None:
    """Return where an estimate sends the fork; None where it does not say."""
    if estimate.face is not None:
        return estimate.face.T_camera_dock, list(estimate.face.pockets)
    info = objects.get(estimate.obj_id)
    if info is None or not info.pockets:
        return None
    faces = docking_faces(info.size, info.pockets)
    face = faces[int(approached_face(estimate.T_camera_object[None], faces)[0])]
    inside = [transform_points(invert(face.T_object_dock), p.T_object_pocket[None, :3, 3])[0, 1:] for p in face.pockets]
    return estimate.T_camera_object @ face.T_object_dock, inside


def estimated(
    estimator: PoseEstimator | None, objects: Mapping[int, ObjectInfo], image: RgbdImage, color: Path
) -> Answer | None:
    """Return where an estimator, or for None the baseline, sends the fork."""
    if estimator is None:
        pixels = image.detections[0].pixels(*image.depth.shape) & (image.depth > 0)
        points = image.camera.unproject(image.depth)[pixels].astype(float)
        return dock_of(points, image.gravity, np.random.default_rng(0)), None
    if estimator.reads_rgb:
        image = replace(image, rgb=decode_any_rgb(color))
    found = estimator.estimate(image)
    return answer_of(found[0], objects) if found else None


def entries(
    estimator: PoseEstimator | None,
    objects: Mapping[int, ObjectInfo],
    recordings: Sequence[RecordedFace],
    masks: str,
    gravity: str,
    model: str | None = None,
) -> list[Entry | None]:
    """Return what the fork does at each face; None where there is no answer."""
    found: list[Entry | None] = []
    for index, recorded in enumerate(recordings):
        down = gravity_of(recorded, gravity, np.random.default_rng([7, index]))
        image = RgbdImage.from_arrays(recorded.depth, recorded.K, [masked(recorded.mask, masks, model)], gravity=down)
        answer = estimated(estimator, objects, image, recorded.color)
        found.append(None if answer is None else drive_in(recorded, *answer))
    return found


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
