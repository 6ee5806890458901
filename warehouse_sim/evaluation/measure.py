"""Every error of every ground truth that counts: the rows that scores are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.reader import ImageRecord, ObjectInfo
from warehouse_sim.evaluation.docking import (
    DockingFace,
    ForkConfig,
    approached_face,
    docking_errors,
    docking_faces,
)
from warehouse_sim.evaluation.docking_failure import failure_axes
from warehouse_sim.evaluation.error_table import ErrorTable, table_from_rows
from warehouse_sim.evaluation.front_docking import front_columns
from warehouse_sim.evaluation.illuminance import Place
from warehouse_sim.evaluation.insertion import DockingSlack, docking_slack
from warehouse_sim.evaluation.mesh_sweep import mesh_slack
from warehouse_sim.evaluation.pairing import Pair, pair_up
from warehouse_sim.evaluation.pose_error import (
    add,
    add_s,
    estimates_in_object,
    mssd,
    nearest_symmetry,
    rotation_error,
    surface_rms,
    translation_error,
)
from warehouse_sim.evaluation.standing import ObjectStanding, Standings
from warehouse_sim.evaluation.surface import ErrorModels, ErrorPoints
from warehouse_sim.geometry.pose import Transforms
from warehouse_sim.schema import PoseEstimate


@dataclass(frozen=True)
class MeasureConfig:
    """What counts as a ground truth, and what must fit into its pockets."""

    min_visible_fraction: float = 0.1
    """Ground truths with a smaller visible share are left out (0-1), as in BOP."""
    min_model_points: int = 50
    """Ground truths whose model is a cloud of fewer points are left out, >= 1: 50, as in the study of 6D poses on KITTI
    that docs/evaluation.md names, which has figures for 100, too. Those with CAD all count."""
    fork: ForkConfig = field(default_factory=ForkConfig)
    """The tines that must enter the pockets."""


def measure(
    predictions: Sequence[PoseEstimate],
    images: Sequence[ImageRecord],
    objects: Mapping[int, ObjectInfo],
    config: MeasureConfig,
    illuminance: Mapping[Place, float] | None = None,
    standings: Standings | None = None,
) -> ErrorTable:
    """Match predictions to the ground truths of ``images`` and measure the errors of each.

    Args:
        predictions: Estimates; every scene, image and object must be among ``images`` and ``objects``.
        images: Images with their targets.
        objects: Geometry by object id.
        config: What counts, and how it is measured.
        illuminance: Of the ground truths (lx), as far as it is known.
        standings: How they stand in their scenes; None is not known.

    Returns:
        One row a counted ground truth, by scene, image and position in the image.
    """
    models = ErrorModels(objects, config.min_model_points)
    pairs = pair_up(predictions, images, models, config.min_visible_fraction)
    groups: dict[int, list[Pair]] = {}
    for pair in pairs:
        groups.setdefault(id(models.info(pair.target)), []).append(pair)
    rows: list[dict[str, Any]] = []
    for mine in groups.values():
        target = mine[0].target
        stand = standings or Standings()
        rows += _rows(mine, predictions, models.info(target), models.points(target), config.fork, stand)
    lux = illuminance or {}
    for row in rows:
        row["illuminance"] = lux.get((row["scene_id"], row["image_id"], row.pop("instance_id")), np.nan)
    rows.sort(key=lambda row: (row["scene_id"], row["image_id"], row["gt_index"]))
    return table_from_rows(rows)


def _rows(
    pairs: Sequence[Pair],
    predictions: Sequence[PoseEstimate],
    info: ObjectInfo,
    points: ErrorPoints,
    fork: ForkConfig,
    standings: Standings,
) -> list[dict[str, Any]]:
    faces, places = docking_faces(info.size, info.pockets), [_place(pair) for pair in pairs]
    free = np.stack([standings.free(place, faces) for place in places])
    approached = approached_face(np.stack([pair.target.T_camera_object for pair in pairs]), faces, free)
    rows = [
        _describe(pair, info, faces[index])
        | _missed(bool(info.pockets))
        | {
            "verdict": standings.verdict(place, faces[index]),
            "stacked": int(standings.stacked(place)),
            "room": standings.room(place, info, faces[index], fork),
        }
        for pair, place, index in zip(pairs, places, approached, strict=True)
    ]
    for index, face in enumerate(faces):
        found = [row for row, pair in enumerate(pairs) if approached[row] == index and pair.prediction >= 0]
        if not found:
            continue
        estimated = np.stack([predictions[pairs[row].prediction].T_camera_object for row in found])
        true = np.stack([pairs[row].target.T_camera_object for row in found])
        lanes = [standings.lane(places[row], info, face, fork) if face.pockets else None for row in found]
        columns = _pose_columns(estimated, true, info, points, face, fork, lanes)
        for place, row in enumerate(found):
            rows[row] |= {name: column[place] for name, column in columns.items()}
            estimate = predictions[pairs[row].prediction]
            rows[row]["score"] = estimate.score
            rows[row]["error_bound"] = np.nan if estimate.error_bound is None else estimate.error_bound
            if estimate.front is not None:
                T_camera_object = pairs[row].target.T_camera_object
                stand = ObjectStanding(standings, places[row], info)
                rows[row] |= front_columns(estimate.front, T_camera_object, faces, fork, stand)
    return rows


def _place(pair: Pair) -> Place:
    return pair.image.scene_id, pair.image.image_id, pair.target.instance_id


def _describe(pair: Pair, info: ObjectInfo, face: DockingFace) -> dict[str, Any]:
    return {
        "scene_id": pair.image.scene_id,
        "image_id": pair.image.image_id,
        "gt_index": pair.target.gt_index,
        "obj_id": info.obj_id,
        "instance_id": pair.target.instance_id,
        "class_name": info.class_name,
        "object_name": info.name,
        "distance": float(np.linalg.norm(pair.target.T_camera_object[:3, 3])),
        "visible_fraction": pair.target.visible_fraction,
        "diameter": info.diameter,
        "prediction": pair.prediction,
        "face": face.name,
    }


def _missed(has_pockets: bool) -> dict[str, Any]:
    errors = ("add", "add_shape", "add_s", "mssd", "surface_rms", "rotation", "translation")
    offsets = ("depth", "lateral", "vertical", "yaw", "pitch")
    slack = -np.inf if has_pockets else np.nan
    return dict.fromkeys((*errors, *offsets), np.inf) | {
        "score": -np.inf,
        "error_bound": np.nan,
        "within_5cm_5deg": 0.0,
        "slack_lateral": slack,
        "slack_vertical": slack,
        "slack_depth": slack,
        "slack_mesh": slack,
        "limiting_error": "missed" if has_pockets else "",
    }


def _pose_columns(
    T_estimated: Transforms,
    T_true: Transforms,
    info: ObjectInfo,
    points: ErrorPoints,
    face: DockingFace,
    fork: ForkConfig,
    lanes: Sequence[Float[np.ndarray, "m 3 3"] | None],
) -> dict[str, Any]:
    alike = estimates_in_object(T_estimated, T_true, info.symmetry)
    least = least_in_shape = add(alike, points.surface).min(axis=-1)
    if info.shape_symmetry is not info.symmetry:
        same_shape = estimates_in_object(T_estimated, T_true, info.shape_symmetry)
        least_in_shape = add(same_shape, points.surface).min(axis=-1)
    best, _ = nearest_symmetry(alike, points.hull)
    close = (translation_error(alike) < 0.05) & (rotation_error(alike) < np.deg2rad(5.0))
    errors = docking_errors(best, face)
    columns: dict[str, Any] = {
        "add": least,
        "add_shape": least_in_shape,
        "add_s": add_s(best, points.surface, points.tree),
        "mssd": mssd(best, points.hull),
        "surface_rms": surface_rms(alike, points.surface).min(axis=-1),
        "rotation": rotation_error(best),
        "translation": translation_error(best),
        "within_5cm_5deg": close.any(axis=-1).astype(float),
        "depth": errors.depth,
        "lateral": errors.lateral,
        "vertical": errors.vertical,
        "yaw": errors.yaw,
        "pitch": errors.pitch,
    }
    if face.pockets:
        slack = docking_slack(best, face, fork)
        columns |= {"slack_lateral": slack.lateral, "slack_vertical": slack.vertical, "slack_depth": slack.depth}
        columns["slack_mesh"] = room = _room_to_surfaces(best, slack, face, info, lanes, fork)
        columns["limiting_error"] = failure_axes(errors, slack, face, fork, room)
    return columns


def _room_to_surfaces(
    T_object_estimated: Transforms,
    slack: DockingSlack,
    face: DockingFace,
    info: ObjectInfo,
    lanes: Sequence[Float[np.ndarray, "m 3 3"] | None],
    fork: ForkConfig,
) -> Float[np.ndarray, " n"]:
    """Return the room to the very pallet of each estimate (m); to the nominal pockets where there is no mesh."""
    room = np.minimum(slack.lateral, slack.vertical)
    astray, underside = np.isneginf(slack.heel), -float(info.size[2]) / 2.0
    for triangles in {id(lane): lane for lane in lanes if lane is not None}.values():
        rows = np.array([lane is triangles for lane in lanes]) & ~astray
        room[rows] = mesh_slack(T_object_estimated[rows], face, underside, triangles, fork)
    return room
