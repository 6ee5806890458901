"""What the simulation is asked: an estimate of a pallet in a scene, from the face that a truck stands before."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.docking.station import Station
from benchmarks.docking.truck import TruckConfig
from warehouse_sim.catalog.parts import solid_box
from warehouse_sim.evaluation.docking import DockingFace, docking_errors
from warehouse_sim.evaluation.docking_failure import failure_axes
from warehouse_sim.evaluation.insertion import docking_slack
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z

_TRUCK_LENGTH, _TRUCK_WIDTH, _TRUCK_HEIGHT, _TRUCK_BEHIND = 2.0, 1.07, 2.15, 0.11
"""Of the truck behind the heels of its forks (m), and how far behind them it begins: the catalog's 1.6 t truck."""
_OVER_FLOOR = 0.05
"""What lies lower on the floor (m), such as markings, a truck drives over."""
_LEVEL = np.deg2rad(3.0)
"""A pallet that lies less level than this (rad), or has fallen, is no case for a truck."""


@dataclass(frozen=True, eq=False)
class Question:
    """One docking to judge."""

    source: str
    """Recipe or dataset, with the predictions file if there is one."""
    scene: int
    image: int
    instance: int
    """Of the pallet in the scene."""
    face: str
    kind: str
    """Where the estimate is from: "truth", "too deep", the one error that was planted, "all" for all, "predicted"."""
    T_object_estimated: Transform
    """Under the best symmetry, in the true object frame."""

    @property
    def place(self) -> dict[str, Any]:
        """Identity as plain data."""
        names = ("source", "scene", "image", "instance", "face", "kind")
        return {name: getattr(self, name) for name in names}


def why_not(station: Station, face: DockingFace, truck: TruckConfig) -> str:
    """Return why no truck takes this pallet from this side, however well it sees it; "" where one can.

    From geometry alone: the boxes that the truck sweeps on the right way against the boxes of all that is not the
    pallet and its load.
    """
    fork = truck.fork
    T_world_dock = station.pallet.T_world_object @ face.T_object_dock
    if not face.pockets:
        return "no pockets"
    if T_world_dock[2, 2] < np.cos(_LEVEL):
        return "does not stand level"
    if any(pocket.size[1] < fork.tine_width or pocket.size[2] < fork.tine_thickness for pocket in face.pockets):
        return "pockets too small"
    if fork.reach < fork.least_insertion * face.depth:
        return "deeper than the tines are long"
    x, y, _ = T_world_dock[:3, 0]
    level = make_transform(rotation_z(float(np.arctan2(y, x))), T_world_dock[:3, 3])
    blocked = min(station.surroundings.gap(box.placed(level), 0.05) for box in _swept(face, truck, level[2, 3]))
    return "no room" if blocked <= 0.0 else ""


def swept_answer(question: Question, face: DockingFace, truck: TruckConfig) -> dict[str, Any]:
    """Return what the swept test says of a question, with the room (m) and errors (m, rad) that it is made of."""
    estimated = question.T_object_estimated[None]
    slack, errors = docking_slack(estimated, face, truck.fork), docking_errors(estimated, face)
    room = {name: float(getattr(slack, name)[0]) for name in ("lateral", "vertical", "heel", "tips")}
    least = min(room.values())
    return {
        "docks": bool(least >= 0.0),
        "room": {name: value if np.isfinite(value) else None for name, value in room.items()},
        "room_at_walls": min(room["lateral"], room["vertical"]) if np.isfinite(least) else None,
        "limiting_error": failure_axes(errors, slack, face, truck.fork)[0],
        "errors": {
            name: float(getattr(errors, name)[0]) for name in ("depth", "lateral", "vertical", "yaw", "pitch", "roll")
        },
    }


def _swept(face: DockingFace, truck: TruckConfig, height: float) -> Iterator[OrientedBox]:
    """Yield boxes in the level dock frame: tines and backrest from start to stop, and the truck behind them.

    Args:
        face: The side.
        truck: The truck.
        height: Of the dock frame over the floor (m).
    """
    fork = truck.fork
    start, stop = -truck.start_gap - fork.tine_length, -fork.heel_gap
    inverse = np.linalg.inv(face.T_object_dock)
    for pocket in face.pockets:
        y = (inverse @ pocket.T_object_pocket)[1, 3]
        long = stop + fork.tine_length - start
        yield solid_box((long, fork.tine_width, fork.tine_thickness), (start + long / 2.0, y, 0.0))
    back = start - fork.tine_thickness - 0.04
    low = 0.08
    size = (stop - back, truck.backrest_width, truck.backrest_height - low)
    yield solid_box(size, ((stop + back) / 2.0, 0.0, (truck.backrest_height + low) / 2.0))
    front, rear = stop - _TRUCK_BEHIND, start - _TRUCK_BEHIND - _TRUCK_LENGTH
    middle = (_OVER_FLOOR + _TRUCK_HEIGHT) / 2.0 - height
    size = (front - rear, _TRUCK_WIDTH, _TRUCK_HEIGHT - _OVER_FLOOR)
    yield solid_box(size, ((front + rear) / 2.0, 0.0, middle))
