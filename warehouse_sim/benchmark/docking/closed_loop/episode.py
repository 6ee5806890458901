"""One episode: an approach, then what the swept-volume check and the simulated truck say of where it goes in."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.belief import Believed
from warehouse_sim.benchmark.docking.closed_loop.drive import ARRIVED, Approach, Approacher, Perceive
from warehouse_sim.benchmark.docking.closed_loop.perceive import Oracle
from warehouse_sim.benchmark.docking.closed_loop.settings import BASE, DRIFTS, Condition
from warehouse_sim.benchmark.docking.closed_loop.starts import Start, collisions_of
from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.benchmark.docking.questions import Question, swept_answer
from warehouse_sim.benchmark.docking.record import stream
from warehouse_sim.evaluation.docking.fork import docking_errors
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.scene import scene_rng

Row = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Setting:
    """What all episodes of a run share."""

    source: str
    """Recipe."""
    seed: int
    camera: PinholeCamera


def episode(
    setting: Setting, start: Start, condition: Condition, method: str, perceive: Perceive
) -> tuple[Row, Approach]:
    """Drive and dock.

    Args:
        setting: Of the run.
        start: Of the truck.
        condition: The level that is measured.
        method: Name of who estimates.
        perceive: Who estimates.

    Returns:
        Outcome ("docked", what failed, or why the truck stopped) with numbers, and the approach.
    """
    scene, pallet = start.station.scene, start.pallet
    # All methods and levels of one start have the same errors of odometry, in units of their deviation.
    drift = scene_rng(setting.seed, scene.scene_index, f"closed loop drift {start.number}")
    approach = _truck(setting, start, condition, perceive).run(start.pose, drift)
    row: Row = {
        "source": setting.source,
        "scene": scene.scene_index,
        "start": start.number,
        "instance": pallet.instance_id,
        "face": start.face.name,
        "condition": condition.name,
        "factor": condition.factor,
        "method": method,
        "approach": approach.ended,
        "outcome": approach.ended,
        "time": approach.time,
        "distance": approach.distance,
        "corrections": approach.corrections,
        "images": approach.images,
    }
    if approach.ended == ARRIVED:
        row |= _inserted(setting, start, approach, f"{condition.name}, {method}")
    return row, approach


def way_is_free(setting: Setting, start: Start) -> bool:
    """Return whether a truck that knows the pallet touches nothing on its way: the law steers around nothing."""
    gt = Oracle(start.pallet, start.station.scene.model_of(start.pallet), setting.camera)
    truck = _truck(setting, start, replace(BASE, delay=0.0, drift="none"), gt)
    return truck.run(start.pose, np.random.default_rng(0)).ended == ARRIVED


def _truck(setting: Setting, start: Start, condition: Condition, perceive: Perceive) -> Approacher:
    scene, faces = start.station.scene, start.station.faces
    believed = Believed(scene.model_of(start.pallet).symmetry, faces, DRIFTS[condition.drift], condition.is_open)
    touches = collisions_of(scene, start)
    return Approacher(start.mount, setting.camera, believed, perceive, condition, touches)


def _inserted(setting: Setting, start: Start, approach: Approach, kind: str) -> Row:
    """Return how the truck goes in along its own axis: the outcome, errors (m, rad), and both judges' answers."""
    assert approach.T_world_dock is not None
    station, face = start.station, start.face
    T = estimate_of(approach.T_world_dock, station.pallet.T_world_object, face.T_object_dock)
    scene = station.scene.scene_index
    question = Question(setting.source, scene, start.number, station.pallet.instance_id, face.name, kind, T)
    errors = docking_errors(T[None], face)
    found = dock(station, face, T, stream(question))
    return {
        "outcome": found.outcome,
        "by": found.by,
        "swept": swept_answer(question, station),
        "force": found.force,
        "push": found.push,
        "errors": {name: float(getattr(errors, name)[0]) for name in ("depth", "lateral", "vertical", "yaw", "pitch")},
    }


def estimate_of(T_world_dock: Transform, T_world_object: Transform, T_object_dock: Transform) -> Transform:
    """Return the estimate, in the true object frame, that would send a truck along a dock frame."""
    return np.asarray(invert(T_world_object) @ T_world_dock @ invert(T_object_dock))
