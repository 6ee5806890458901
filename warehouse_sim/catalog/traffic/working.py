"""The trucks at work: each with the place of its driver and of its load, in its own frame."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import Triple
from warehouse_sim.catalog.traffic import drive_trucks, trucks, walked_trucks
from warehouse_sim.catalog.traffic.people import feet_of, hips_of
from warehouse_sim.catalog.traffic.shapes import assembled, centre_of
from warehouse_sim.catalog.traffic.truck_pieces import FORK_SPREAD, FORK_WIDTH
from warehouse_sim.catalog.traffic.trucks import JACK_FORK, JACK_LOWERED, JACK_SPREAD
from warehouse_sim.catalog.traffic.walked_trucks import JACK_RAISED
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z
from warehouse_sim.schema import ObjectModel, Part


@dataclass(frozen=True)
class Place:
    """Where a load is carried; truck frame: x forwards, z up from the floor."""

    top: float
    """Height of the blades or the deck (m)."""
    back: float
    """x that the load's back comes up to (m)."""
    forks: tuple[float, float] | None
    """Distance of the blades' middles and their width (m); None for a deck."""
    most_mass: float
    """Greatest mass (kg)."""
    length: float = np.inf
    """Greatest length of the pallet along x (m)."""


@dataclass(frozen=True)
class Driver:
    """Who drives or walks with it."""

    pose: str
    """Pose of the worker."""
    at: Triple
    """Between the hips of who sits, under the feet of who stands (m)."""
    yaw: float = 0.0
    """Heading (rad)."""
    statures: tuple[str, ...] = ("small", "medium", "tall")
    """Who fits."""


@dataclass(frozen=True)
class WorkingTruck:
    """What a truck is made of, who drives it and what it carries."""

    obj_id: int
    class_name: str
    mass: float
    parts: Callable[[], list[Part]]
    solids: Callable[[], list[OrientedBox]]
    place: Place | None
    driver: Driver | None
    hitch: float | None = None
    """x of the coupling (m); None for what draws nothing."""


_BLADES, _WIDE = (FORK_SPREAD, FORK_WIDTH), (JACK_SPREAD, JACK_FORK)
_JACK = walked_trucks.hand_pallet_truck_parts
_JACK_SOLIDS = walked_trucks.hand_pallet_truck_solids
WORKING = {
    "work_counterbalance": WorkingTruck(
        *(571, "forklift", 3100.0, trucks.counterbalance_parts, trucks.counterbalance_solids),
        Place(trucks.COUNTERBALANCE_TOP, 0.02, _BLADES, 1500.0),
        Driver("seated", (-1.29, 0.0, 0.99)),
    ),
    "work_reach": WorkingTruck(
        *(572, "forklift", 3300.0, trucks.reach_parts, trucks.reach_truck_solids),
        Place(trucks.REACH_TOP, 0.02, _BLADES, 1400.0),
        Driver("seated", (-0.86, 0.40, 1.05), -np.pi / 2, ("small", "medium")),
    ),
    "work_stacker": WorkingTruck(
        *(573, "forklift", 850.0, walked_trucks.stacker_parts, walked_trucks.stacker_solids),
        Place(walked_trucks.STACKER_TOP, 0.02, _WIDE, 1200.0),
        Driver("pushing", (-1.72, 0.0, 0.0)),
    ),
    "work_order_picker": WorkingTruck(
        *(574, "forklift", 1100.0, drive_trucks.order_picker_parts, drive_trucks.order_picker_solids),
        Place(drive_trucks.PICKER_TOP, 0.02, _WIDE, 1500.0),
        Driver("driving", (-0.82, 0.0, drive_trucks.PICKER_STAND), np.pi),
    ),
    "work_tugger": WorkingTruck(
        *(575, "tugger", 1250.0, drive_trucks.tugger_parts, drive_trucks.tugger_solids),
        *(None, Driver("driving", (-0.27, 0.0, drive_trucks.TUGGER_STAND)), -0.80),
    ),
    "work_cart": WorkingTruck(
        *(576, "cart", 95.0, drive_trucks.cart_parts, drive_trucks.cart_solids),
        Place(drive_trucks.CART_TOP, 0.02, None, 1000.0, drive_trucks.CART_LENGTH),
        None,
    ),
    "work_robot": WorkingTruck(
        *(577, "amr", 260.0, drive_trucks.robot_parts, drive_trucks.robot_solids),
        Place(drive_trucks.ROBOT_TOP, 0.0, None, 1000.0, drive_trucks.ROBOT_LENGTH + 0.02),
        None,
    ),
    "work_pallet_truck": WorkingTruck(
        *(578, "pallet_jack", 68.0, partial(_JACK, JACK_RAISED), partial(_JACK_SOLIDS, JACK_RAISED)),
        Place(JACK_RAISED, 0.02, _WIDE, 1500.0),
        Driver("pushing", (-1.06, 0.0, 0.0)),
    ),
    "hand_pallet_truck": WorkingTruck(
        *(579, "pallet_jack", 68.0, partial(_JACK, JACK_LOWERED), partial(_JACK_SOLIDS, JACK_LOWERED)), None, None
    ),
}
"""Catalog name -> truck; the last one stands about."""
CART_HITCH = drive_trucks.CART_LENGTH + 0.52
"""x of the eye of a cart's drawbar (m)."""


@cache
def truck_frame(name: str) -> Transform:
    """Return ``T_object_truck``: the truck frame seen from the model's origin."""
    return make_transform(translation=-centre_of(WORKING[name].parts()))


def working_truck(name: str) -> ObjectModel:
    """Build a truck that is at work."""
    truck = WORKING[name]
    return assembled(name, truck.class_name, truck.obj_id, truck.parts(), truck.solids(), truck.mass)


def driver_pose(driver: Driver, worker: str) -> Transform:
    """Return ``T_truck_worker`` of the catalog's ``worker`` in the place of ``driver``."""
    T_worker_anchor = hips_of(worker) if driver.pose == "seated" else feet_of(worker)
    at: Float[np.ndarray, " 3"] = np.asarray(driver.at, dtype=float)
    return make_transform(rotation_z(driver.yaw), at) @ invert(T_worker_anchor)
