"""Poses whatever kind they are of: whether a truck docks does not depend on what the catalog calls the pallet."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, ObjectInfo, TargetRecord
from warehouse_sim.evaluation.docking.fork import DockingFace, approached_face, docking_faces
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.measuring import MIN_VISIBLE
from warehouse_sim.evaluation.pairing import match
from warehouse_sim.evaluation.scored_estimates import ScoredEstimates
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.schema import PalletFace, PoseEstimate


def under_any_name(
    predictions: str | Path | Sequence[PoseEstimate], reader: DatasetReader, split: str
) -> list[PoseEstimate]:
    """Return the predictions that answer for a ground truth of their class, under the name of that ground truth.

    Each gets the face with pockets of the kind that it was predicted as, on the side that is approached: scored, the
    fork goes where that kind has its openings, and meets the pallet that is there. Its pose is the one of the other
    kind with this face in the same place, so that errors by ADD and MSSD are of faces, not of centres. As many are kept
    of a class in an image as there are ground truths that count (``pairing.match``).

    Args:
        predictions: As ``evaluate`` takes them.
        reader: The dataset.
        split: Which images, as in ``evaluate``.

    Returns:
        At most one estimate a ground truth; classes without pockets are left as they are.

    Raises:
        EvaluationError: As ``evaluate``: a prediction names an image or object that the split lacks.
        DatasetError: The dataset or the CSV cannot be read.
    """
    images, objects = reader.images(split), reader.objects
    standings, given = Standings.of(reader, images), ScoredEstimates.of(predictions)
    given.check(images, split, reader)
    by_place: dict[tuple[int, int, str], list[PoseEstimate]] = defaultdict(list)
    for item in given.estimates:
        by_place[item.scene_id, item.image_id, objects[item.obj_id].class_name].append(item)
    found = []
    for image in images:
        alike: dict[str, list[TargetRecord]] = defaultdict(list)
        for target in image.targets:
            alike[objects[target.obj_id].class_name].append(target)
        for class_name, targets in alike.items():
            mine = by_place[image.scene_id, image.image_id, class_name]
            numbers = {item.obj_id for item in mine} | {target.obj_id for target in targets}
            if all(objects[number].pockets for number in numbers):
                found += _renamed(mine, image, targets, objects, standings)
            else:
                found += mine
    return found


def _renamed(
    estimates: Sequence[PoseEstimate],
    image: ImageRecord,
    targets: Sequence[TargetRecord],
    objects: Mapping[int, ObjectInfo],
    standings: Standings,
) -> list[PoseEstimate]:
    sides = [_approached(image, target, objects[target.obj_id], standings) for target in targets]
    docks = [target.T_camera_object @ side.T_object_dock for target, side in zip(targets, sides, strict=True)]
    own = [[_towards(item, objects[item.obj_id], dock) for dock in docks] for item in estimates]
    errors = np.array(
        [
            [_apart(item, face, dock) for face, dock in zip(row, docks, strict=True)]
            for item, row in zip(estimates, own, strict=True)
        ]
    ).reshape(len(estimates), len(targets))
    limits = np.array([objects[target.obj_id].diameter for target in targets])
    counted = np.array([target.visible_fraction >= MIN_VISIBLE for target in targets])
    scores = np.array([item.score for item in estimates])
    matched = match(np.where(errors < limits, errors, np.inf), scores, counted)
    renamed = []
    for column, row in enumerate(matched.tolist()):
        if row >= 0:
            item, face, info = estimates[row], own[row][column], objects[targets[column].obj_id]
            T_camera_dock = item.T_camera_object @ face.T_object_dock
            T_camera_object = T_camera_dock @ invert(sides[column].T_object_dock)
            entered = _entered(T_camera_dock, face, objects[item.obj_id].size)
            renamed.append(
                replace(item, obj_id=info.obj_id, name=info.name, T_camera_object=T_camera_object, face=entered)
            )
    return renamed


def _approached(image: ImageRecord, target: TargetRecord, info: ObjectInfo, standings: Standings) -> DockingFace:
    """Return the side by which the true pallet is evaluated."""
    faces = docking_faces(info.size, info.pockets)
    free = standings.free((image.scene_id, image.image_id, target.instance_id), faces)
    return faces[int(approached_face(target.T_camera_object[None], faces, free[None])[0])]


def _towards(item: PoseEstimate, info: ObjectInfo, T_camera_dock: Transform) -> DockingFace:
    """Return the side of an estimate that is entered most nearly in the true direction."""
    inwards = item.T_camera_object[:3, :3].T @ T_camera_dock[:3, 0]
    return max(docking_faces(info.size, info.pockets), key=lambda face: float(face.T_object_dock[:3, 0] @ inwards))


def _apart(item: PoseEstimate, face: DockingFace, T_camera_dock: Transform) -> float:
    """Return how far the entry of an estimate is from the true one (m)."""
    entry = (item.T_camera_object @ face.T_object_dock)[:3, 3]
    return float(np.linalg.norm(entry - T_camera_dock[:3, 3]))


def _entered(T_camera_dock: Transform, face: DockingFace, size: Float[np.ndarray, " 3"]) -> PalletFace:
    """Return a side as what is seen of it: where its openings are, taken as exact."""
    T_dock_object = invert(face.T_object_dock)
    pockets = sorted(face.pockets, key=lambda item: float((T_dock_object @ item.T_object_pocket)[1, 3]))
    centres = np.array([(T_dock_object @ item.T_object_pocket)[1:3, 3] for item in pockets])
    count = len(pockets)
    wide = float(np.abs(T_dock_object[1, :3]) @ size)
    return PalletFace(
        T_camera_dock=T_camera_dock,
        covariance=np.zeros((6, 6)),
        pockets=centres,
        pockets_covariance=np.zeros((count, 2, 2)),
        pocket_sizes=np.array([item.size[1:] for item in pockets]),
        pocket_sizes_covariance=np.zeros((count, 2, 2)),
        size=np.array([wide, size[2]]),
        size_covariance=np.zeros((2, 2)),
    )
