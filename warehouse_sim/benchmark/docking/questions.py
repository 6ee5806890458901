"""What the simulated truck is sent to: an estimate of a pallet in a scene, and what the swept-volume check says."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.evaluation.docking.fork import DockingFace, docking_errors
from warehouse_sim.evaluation.docking.insertion import docking_slack, failure_axes
from warehouse_sim.evaluation.docking.mesh_sweep import lane_triangles, mesh_slack
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import FREE, UNDER_A_STACK


@dataclass(frozen=True, eq=False)
class Question:
    """One docking to judge."""

    source: str
    """Recipe, or dataset with the predictions file."""
    scene: int
    image: int
    instance: int
    """Of the pallet in the scene."""
    face: str
    kind: str
    """Where the estimate is from, such as "predicted"."""
    T_object_estimated: Transform
    """Under the best symmetry, in the true object frame."""

    @property
    def place(self) -> dict[str, Any]:
        """Identity as plain data."""
        names = ("source", "scene", "image", "instance", "face", "kind")
        return {name: getattr(self, name) for name in names}


def why_not(station: Station, face: DockingFace, verdict: str) -> str:
    """Return why docking is not evaluated for this pallet from this side, as the scores have it; "" where it does.

    Args:
        station: The pallet.
        face: The side.
        verdict: What accessibility says of that side.
    """
    if verdict not in (FREE, UNDER_A_STACK):
        return verdict
    clearance = clearances(station, face, np.eye(4))
    return "" if min(clearance.values()) >= 0.0 else "no clearance for the tines"


def clearances(station: Station, face: DockingFace, T_object_estimated: Transform) -> dict[str, float]:
    """Return the clearance (m) that an estimate leaves: to the pallet's own mesh ("mesh"), and along the tines."""
    slack = docking_slack(T_object_estimated[None], face)
    model = station.scene.model_of(station.pallet)
    lanes = lane_triangles(model.mesh(), face)
    mesh = mesh_slack(T_object_estimated[None], face, -float(model.size[2]) / 2.0, lanes)
    astray = np.isneginf(slack.heel)
    found = {"mesh": np.where(astray, -np.inf, mesh), "heel": slack.heel, "tips": slack.tips}
    return {name: float(value[0]) for name, value in found.items()}


def swept_answer(question: Question, station: Station) -> dict[str, Any]:
    """Return the swept-volume check's answer, with the clearances (m) and errors (m, rad) behind it."""
    face = station.face(question.face)
    estimated = question.T_object_estimated[None]
    slack, errors = docking_slack(estimated, face), docking_errors(estimated, face)
    clearance = clearances(station, face, question.T_object_estimated)
    at_walls = float(np.minimum(slack.lateral, slack.vertical)[0])
    return {
        "docks": bool(min(clearance.values()) >= 0.0),
        "clearance": {name: value if np.isfinite(value) else None for name, value in clearance.items()},
        "clearance_nominal": at_walls if np.isfinite(at_walls) else None,
        "gt_clearance": clearances(station, face, np.eye(4))["mesh"],
        "limiting_error": failure_axes(errors, slack, face, np.array([clearance["mesh"]]))[0],
        "errors": {
            name: float(getattr(errors, name)[0]) for name in ("depth", "lateral", "vertical", "yaw", "pitch", "roll")
        },
    }
