"""Every error of every ground truth that counts: the rows that scores are made of."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.dataset.reader import ImageRecord, ObjectInfo
from warehouse_sim.evaluation.docking.fork import DockingFace, approached_face, docking_errors, docking_faces
from warehouse_sim.evaluation.docking.insertion import DockingSlack, docking_slack, failure_axes
from warehouse_sim.evaluation.docking.mesh_sweep import mesh_slack
from warehouse_sim.evaluation.docking.standing import Standings, face_columns
from warehouse_sim.evaluation.error_table import ErrorTable, table_from_columns
from warehouse_sim.evaluation.errors.pose_error import (
    add,
    add_s,
    estimates_in_object,
    mssd,
    nearest_symmetry,
    rotation_error,
    surface_rms,
    translation_error,
)
from warehouse_sim.evaluation.errors.surface import ErrorModels, ErrorPoints
from warehouse_sim.evaluation.pairing import Pair, Place, pair_up
from warehouse_sim.geometry.pose import Transforms
from warehouse_sim.schema import PoseEstimate

MIN_VISIBLE = 0.1
"""Ground truths with a smaller visible fraction are left out, as in BOP."""
MIN_MODEL_POINTS = 50
"""Ground truths whose model is a cloud of fewer points are left out: 50, as in the study of 6D poses on KITTI that
docs/evaluation.md names, which has figures for 100, too. Those with CAD all count."""


def measure(
    predictions: Sequence[PoseEstimate],
    images: Sequence[ImageRecord],
    objects: Mapping[int, ObjectInfo],
    illuminance: Mapping[Place, float] | None = None,
    standings: Standings | None = None,
    min_visible: float = MIN_VISIBLE,
) -> ErrorTable:
    """Match predictions to the ground truths of ``images`` and measure the errors of each.

    Args:
        predictions: Estimates; every scene, image and object must be among ``images`` and ``objects``.
        images: Images with their targets.
        objects: Geometry by object id.
        illuminance: Of the ground truths (lx), as far as it is known.
        standings: How they stand in their scenes; None is not known.
        min_visible: Visible fraction (0-1) from which a ground truth counts.

    Returns:
        One row a counted ground truth, by scene, image and position in the image.
    """
    models = ErrorModels(objects, MIN_MODEL_POINTS)
    pairs = pair_up(predictions, images, models, min_visible)
    groups: dict[int, list[Pair]] = {}
    for pair in pairs:
        groups.setdefault(id(models.info(pair.target)), []).append(pair)
    parts = []
    for mine in groups.values():
        target = mine[0].target
        columns = object_columns(
            mine, predictions, models.info(target), models.points(target), standings or Standings()
        )
        lux = illuminance or {}
        parts.append(columns | {"illuminance": [lux.get(pair.place, np.nan) for pair in mine]})
    return table_from_columns(parts)


_ERRORS = ("add", "add_shape", "add_s", "mssd", "surface_rms", "rotation", "translation")
_OFFSETS = ("depth", "lateral", "vertical", "yaw", "pitch")
_SLACKS = ("slack_lateral", "slack_vertical", "slack_depth", "slack_mesh")


def object_columns(
    pairs: Sequence[Pair],
    predictions: Sequence[PoseEstimate],
    info: ObjectInfo,
    points: ErrorPoints,
    standings: Standings,
) -> dict[str, Any]:
    """Return the columns of some ground truths, each as long as ``pairs``; "illuminance" is left to others.

    Args:
        pairs: Ground truths of one object with their estimates.
        predictions: All estimates.
        info: The object.
        points: Where its errors are measured.
        standings: How they stand in their scenes.
    """
    faces, places = docking_faces(info.size, info.pockets), [pair.place for pair in pairs]
    true = np.stack([pair.target.T_camera_object for pair in pairs])
    approached = approached_face(true, faces, np.stack([standings.free(place, faces) for place in places]))
    columns = _describe(pairs, info, true) | _missed(len(pairs), bool(info.pockets))
    sides = [faces[index] for index in approached]
    columns |= {
        "face": np.array([face.name for face in sides]),
        "verdict": [standings.verdict(place, face) for place, face in zip(places, sides, strict=True)],
        "stacked": [int(standings.stacked(place)) for place in places],
        "clearance": [standings.clearance(place, info, face) for place, face in zip(places, sides, strict=True)],
    }
    found = np.flatnonzero(columns["prediction"] >= 0)
    if len(found) == 0:
        return columns
    estimates = [predictions[pairs[row].prediction] for row in found.tolist()]
    estimated = np.stack([estimate.T_camera_object for estimate in estimates])
    errors, best = _pose_columns(estimated, true[found], info, points)
    errors["score"] = [estimate.score for estimate in estimates]
    errors["error_bound"] = [np.nan if item.error_bound is None else item.error_bound for item in estimates]
    _fill(columns, found, errors)
    for index, face in enumerate(faces):
        mine = approached[found] == index
        rows = found[mine]
        if len(rows):
            lanes = [standings.lane(places[row], info, face) if face.pockets else None for row in rows]
            _fill(columns, rows, _docking_columns(best[mine], info, face, lanes))
    for row, estimate in zip(found.tolist(), estimates, strict=True):
        if estimate.face is not None:
            _fill(columns, row, face_columns(estimate.face, true[row], faces, (standings, places[row], info)))
    return columns


def _fill(columns: dict[str, Any], rows: Int[np.ndarray, " k"] | int, values: dict[str, Any]) -> None:
    for name, value in values.items():
        columns[name][rows] = value


def _describe(pairs: Sequence[Pair], info: ObjectInfo, T_camera_object: Transforms) -> dict[str, Any]:
    count = len(pairs)
    return {
        "scene_id": np.array([pair.image.scene_id for pair in pairs]),
        "image_id": np.array([pair.image.image_id for pair in pairs]),
        "gt_index": np.array([pair.target.gt_index for pair in pairs]),
        "obj_id": np.full(count, info.obj_id),
        "class_name": np.full(count, info.class_name),
        "object_name": np.full(count, info.name),
        "distance": np.linalg.norm(T_camera_object[:, :3, 3], axis=1),
        "visible_fraction": np.array([pair.target.visible_fraction for pair in pairs]),
        "diameter": np.full(count, info.diameter),
        "prediction": np.array([pair.prediction for pair in pairs]),
    }


def _missed(count: int, has_pockets: bool) -> dict[str, Any]:
    """Return what stands in the rows of ground truths without an estimate."""
    slack = -np.inf if has_pockets else np.nan
    return {
        **{name: np.full(count, np.inf) for name in (*_ERRORS, *_OFFSETS)},
        **{name: np.full(count, slack) for name in _SLACKS},
        "score": np.full(count, -np.inf),
        "error_bound": np.full(count, np.nan),
        "within_5cm_5deg": np.zeros(count),
        "limiting_error": np.full(count, "missed" if has_pockets else "", dtype="<U16"),
    }


def _pose_columns(
    T_estimated: Transforms, T_gt: Transforms, info: ObjectInfo, points: ErrorPoints
) -> tuple[dict[str, Any], Transforms]:
    """Return what does not depend on a side, and the estimates in the object frame under the best symmetry."""
    alike = estimates_in_object(T_estimated, T_gt, info.symmetry)
    least = least_in_shape = add(alike, points.surface).min(axis=-1)
    if info.shape_symmetry is not info.symmetry:
        same_shape = estimates_in_object(T_estimated, T_gt, info.shape_symmetry)
        least_in_shape = add(same_shape, points.surface).min(axis=-1)
    best, _ = nearest_symmetry(alike, points.hull)
    close = (translation_error(alike) < 0.05) & (rotation_error(alike) < np.deg2rad(5.0))
    return {
        "add": least,
        "add_shape": least_in_shape,
        "add_s": add_s(best, points.surface, points.tree),
        "mssd": mssd(best, points.hull),
        "surface_rms": surface_rms(alike, points.surface).min(axis=-1),
        "rotation": rotation_error(best),
        "translation": translation_error(best),
        "within_5cm_5deg": close.any(axis=-1).astype(float),
    }, best


def _docking_columns(
    best: Transforms,
    info: ObjectInfo,
    face: DockingFace,
    lanes: Sequence[Float[np.ndarray, "m 3 3"] | None],
) -> dict[str, Any]:
    """Return what depends on the side that is approached."""
    errors = docking_errors(best, face)
    columns: dict[str, Any] = {name: getattr(errors, name) for name in _OFFSETS}
    if face.pockets:
        slack = docking_slack(best, face)
        columns |= {"slack_lateral": slack.lateral, "slack_vertical": slack.vertical, "slack_depth": slack.depth}
        columns["slack_mesh"] = clearance = _clearance_to_surfaces(best, slack, face, info, lanes)
        columns["limiting_error"] = failure_axes(errors, slack, face, clearance)
    return columns


def _clearance_to_surfaces(
    T_object_estimated: Transforms,
    slack: DockingSlack,
    face: DockingFace,
    info: ObjectInfo,
    lanes: Sequence[Float[np.ndarray, "m 3 3"] | None],
) -> Float[np.ndarray, " n"]:
    """Return the clearance to the very pallet of each estimate (m); to the nominal pockets where there is no mesh."""
    clearance = np.minimum(slack.lateral, slack.vertical)
    astray, underside = np.isneginf(slack.heel), -float(info.size[2]) / 2.0
    for triangles in {id(lane): lane for lane in lanes if lane is not None}.values():
        rows: Bool[np.ndarray, " n"] = np.array([lane is triangles for lane in lanes]) & ~astray
        clearance[rows] = mesh_slack(T_object_estimated[rows], face, underside, triangles)
    return clearance
