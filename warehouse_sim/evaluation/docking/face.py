"""Docking by a face: where a fork goes that believes the estimated dock frame and pockets, not a CAD's."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_sim.evaluation.docking.failure import failure_axes
from warehouse_sim.evaluation.docking.fork import DockingFace, ForkConfig, docking_errors
from warehouse_sim.evaluation.docking.insertion import DockingSlack, docking_slack
from warehouse_sim.evaluation.docking.mesh_sweep import mesh_slack
from warehouse_sim.evaluation.docking.standing import ObjectStanding
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.schema import FREE, UNDER_A_STACK, PalletFace


def face_columns(
    estimated: PalletFace,
    T_camera_object: Transform,
    faces: Sequence[DockingFace],
    fork: ForkConfig,
    standing: ObjectStanding | None = None,
) -> dict[str, Any]:
    """Return what a row of scores says of docking, for the face that the face means: the one with its direction.

    Args:
        estimated: The estimate.
        T_camera_object: The true pose.
        faces: Sides of the object that can be approached.
        fork: The tines.
        standing: How the object stands in its scene; None is not known.

    Returns:
        Columns of the error table; none where that side has not as many pockets as the face.
    """
    T_object_dock = invert(T_camera_object) @ estimated.T_camera_dock
    face = max(faces, key=lambda item: float(item.T_object_dock[:3, 0] @ T_object_dock[:3, 0]))
    if not face.pockets or len(face.pockets) != len(estimated.pockets):
        return {}
    T_object_estimated = (T_object_dock @ invert(face.T_object_dock))[None]
    aside = [(invert(face.T_object_dock) @ pocket.T_object_pocket)[1, 3] for pocket in face.pockets]
    ordered = estimated.pockets[np.argsort(estimated.pockets[:, 0])]
    centres = ordered[np.argsort(np.argsort(aside))]
    tines = [make_transform(np.eye(3), np.array([0.0, *centre])) for centre in centres]
    errors = docking_errors(T_object_estimated, face)
    slack = docking_slack(T_object_estimated, face, fork, tines)
    clearance = np.minimum(slack.lateral, slack.vertical)
    limiting: str | None = None
    if standing is not None:
        place, info, standings = standing.place, standing.info, standing.standings
        lane = standings.lane(place, info, face, fork)
        if lane is not None and np.isfinite(slack.heel[0]):
            clearance = mesh_slack(T_object_estimated, face, -float(info.size[2]) / 2.0, lane, fork, tines)
        if standings.verdict(place, face) not in ("", FREE, UNDER_A_STACK):
            # The truck would go where it cannot stand.
            limiting = "wrong_face"
            slack, clearance = DockingSlack(*np.full((4, 1), -np.inf)), np.array([-np.inf])
    return {
        "face": face.name,
        **{name: float(getattr(errors, name)[0]) for name in ("depth", "lateral", "vertical", "yaw", "pitch")},
        "slack_lateral": float(slack.lateral[0]),
        "slack_vertical": float(slack.vertical[0]),
        "slack_depth": float(slack.depth[0]),
        "slack_mesh": float(clearance[0]),
        "limiting_error": limiting or failure_axes(errors, slack, face, fork, clearance)[0],
    }
