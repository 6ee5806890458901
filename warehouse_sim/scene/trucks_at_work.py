"""Trucks at work in the aisle: with driver, most with a load on the forks, along the aisle or square to its sides."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.people import WORKERS_BY_NAME
from warehouse_sim.catalog.traffic.truck_pieces import FORK_THICKNESS
from warehouse_sim.catalog.traffic.working import CART_HITCH, WORKING, Place, driver_pose, truck_frame
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.loads.resting import lowered_load
from warehouse_sim.scene.loads.unit_load import UnitLoad, UnitLoadConfig, build_unit_load
from warehouse_sim.schema import ObjectModel

KINDS = {
    "counterbalance": "work_counterbalance",
    "reach": "work_reach",
    "stacker": "work_stacker",
    "order_picker": "work_order_picker",
    "tugger": "work_tugger",
    "amr": "work_robot",
    "pallet_truck": "work_pallet_truck",
}
"""Name in a recipe -> name in the catalog."""
CLEARANCE = 0.3
"""Least distance of trucks, people and what lies on the floor from each other and from all else (m)."""
_TRIES, _LOAD_TRIES = 60, 4
_ALONG_FRACTION = 0.6
"""Fraction of the trucks that drive along the aisle; the others face a side, as when they pick up or put away."""
_HEADING_SPREAD = 0.04
"""Standard deviation of the heading (rad)."""
_BEFORE_SIDE = (0.15, 1.2)
"""Distance (m) of what is foremost from the side that a truck faces."""
_LADEN_FRACTION = 0.7
"""Fraction of the trucks that carry a load of the recipe's."""
_MOST_PIECES = 24
"""Pieces on one pallet."""
_MOST_CARTS = 2
_LEAST_DEPTH = 0.6
"""Least depth of a pallet on forks (m)."""
_TOUCH = 0.0005
"""Boxes that are this deep in each other touch (m)."""
_LOAD_HEIGHT = 1.7
"""Greatest height of a load on the forks, pallet included (m): its driver looks over or past it."""
UNDERFOOT, OVERHEAD = 0.05, 3.0
"""What ends below the first or begins above the second height is in no truck's or person's way (m)."""

Pieces = list[tuple[ObjectModel, Transform]]


@dataclass(frozen=True, eq=False)
class Crew:
    """A truck with all that moves with it, in the truck frame: x forwards, z up from the floor."""

    single: Pieces
    """Truck, driver, carts."""
    loads: list[Pieces]
    """Unit loads, each with its pallet first."""

    def boxes(self) -> list[OrientedBox]:
        """Return the box around each piece and each load."""
        around = [OrientedBox(T, model.size) for model, T in self.single]
        return around + [UnitLoad(tuple(load)).envelope for load in self.loads]

    def add_to(self, draft: SceneDraft, T_world_truck: Transform) -> None:
        """Add all of it to ``draft``; nothing of it moves."""
        for model, T in self.single:
            draft.add(model, T_world_truck @ T)
        for load in self.loads:
            group = draft.new_group()
            for model, T in load:
                draft.add(model, T_world_truck @ T, group, fixed=True)


def add_trucks_at_work(
    draft: SceneDraft,
    count: int,
    kinds: Sequence[str],
    loads: UnitLoadConfig,
    area: Area,
    rng: np.random.Generator,
) -> None:
    """Put trucks with drivers on the floor of ``area``; what finds no place is left out.

    Args:
        draft: Where to add them.
        count: How many.
        kinds: Keys of ``KINDS`` to draw from.
        loads: What the recipe says of loads.
        area: Floor of the aisle.
        rng: Stream to draw from.
    """
    if count == 0:
        return
    crowd = draft.crowd(UNDERFOOT, OVERHEAD)
    for _ in range(count):
        crew = sample_crew(str(rng.choice(list(kinds))), loads, rng)
        for _ in range(_TRIES):
            T_world_truck = _sample_pose(crew.boxes(), area, rng)
            boxes = [box.placed(T_world_truck) for box in crew.boxes()]
            inside = all(area.contains(corner) for box in boxes for corner in box.corners())
            if inside and crowd.takes(boxes, CLEARANCE):
                crew.add_to(draft, T_world_truck)
                break


def sample_crew(kind: str, loads: UnitLoadConfig, rng: np.random.Generator) -> Crew:
    """Draw a truck of this kind with its driver and, by chance, its load."""
    name = KINDS[kind]
    truck = WORKING[name]
    crew = Crew([(catalog_object(name), invert(truck_frame(name)))], [])
    if truck.driver is not None:
        worker = f"worker_{truck.driver.statures[int(rng.integers(len(truck.driver.statures)))]}_{truck.driver.pose}"
        assert worker in WORKERS_BY_NAME
        crew.single.append((catalog_object(worker), driver_pose(truck.driver, worker)))
    places = [(name, np.eye(4))]
    if truck.hitch is not None:
        x = truck.hitch
        for _ in range(int(rng.integers(1, _MOST_CARTS + 1))):
            T_truck_cart = make_transform(translation=np.array([x - CART_HITCH, 0.0, 0.0]))
            crew.single.append((catalog_object("work_cart"), T_truck_cart @ invert(truck_frame("work_cart"))))
            places.append(("work_cart", T_truck_cart))
            x -= CART_HITCH
    for carrier, T_truck_place in places:
        place = WORKING[carrier].place
        if place is not None and rng.random() < _LADEN_FRACTION:
            load = _sample_load(place, _boxes_of(carrier), loads, rng)
            if load is not None:
                crew.loads.append([(model, T_truck_place @ T) for model, T in load])
    return crew


def _sample_load(place: Place, carrier: BoxStack, loads: UnitLoadConfig, rng: np.random.Generator) -> Pieces | None:
    """Draw a unit load and lift it onto ``place``; None where no pallet of a few draws goes onto the ``carrier``."""
    config = replace(
        loads,
        max_cartons=min(loads.max_cartons, _MOST_PIECES),
        damaged_fraction=0.0,
        mixed_fraction=0.0,
        carrier_fraction=0.0,
    )
    for _ in range(_LOAD_TRIES):
        sampled = build_unit_load(_LOAD_HEIGHT, config, rng, most_mass=place.most_mass)
        load = UnitLoad(tuple(lowered_load(sampled.pieces)))
        ways = [pose for pose in _ways_on(load, place) if _is_free(load, pose, carrier)]
        if ways:
            T_place_load = ways[int(rng.integers(len(ways)))]
            return [(model, T_place_load @ T) for model, T in load.pieces]
    return None


@cache
def _boxes_of(truck: str) -> BoxStack:
    """Return the collision boxes of a truck in its own frame."""
    T_truck_object = invert(truck_frame(truck))
    return BoxStack.of([box.placed(T_truck_object) for box in catalog_object(truck).collision])


def _is_free(load: UnitLoad, T_place_load: Transform, carrier: BoxStack) -> bool:
    """Return whether the load only touches what carries it: wheels and arms under it can be in a pallet's way."""
    return all(
        carrier.clear_of(box.placed(T_place_load @ T), -_TOUCH) for model, T in load.pieces for box in model.collision
    )


def _ways_on(load: UnitLoad, place: Place) -> list[Transform]:
    """Return each ``T_place_load`` in which ``place`` takes the pallet: forks in its pockets, or flat on the deck."""
    if place.forks is None:
        headings = [(yaw, place.top) for yaw in (0.0, np.pi) if load.pallet.size[0] <= place.length]
    else:
        headings = _headings_on(load.pallet, place.top, *place.forks)
    poses = []
    for yaw, bottom in headings:
        T_turn = make_transform(rotation_z(yaw), np.array([0.0, 0.0, bottom]))
        box = UnitLoad(tuple((model, T_turn @ T) for model, T in load.pieces)).envelope
        start = place.back - float(box.corners()[:, 0].min())
        if place.forks is None:  # amid the deck
            start = place.length / 2
        poses.append(make_transform(translation=np.array([start, 0.0, 0.0])) @ T_turn)
    return poses


def _headings_on(pallet: ObjectModel, top: float, spread: float, width: float) -> list[tuple[float, float]]:
    """Return each heading (rad) of ``pallet`` on forks whose blades lie at ``top``, with its underside's height (m)."""
    found = []
    for face, yaw, across in (("-x", 0.0, 1), ("+x", np.pi, 1), ("-y", -np.pi / 2, 0), ("+y", np.pi / 2, 0)):
        pockets = [pocket for pocket in pallet.pockets if pocket.face == face]
        fit = [
            abs(spread / 2 - abs(pocket.T_object_pocket[across, 3])) + width / 2 < pocket.size[1] / 2
            and pocket.size[2] > FORK_THICKNESS
            for pocket in pockets
        ]
        if len(pockets) == 2 and all(fit) and pallet.size[1 - across] >= _LEAST_DEPTH:
            ceiling = min(float(pocket.T_object_pocket[2, 3] + pocket.size[2] / 2) for pocket in pockets)
            found.append((yaw, top - (ceiling + float(pallet.size[2]) / 2)))
    return found


def _sample_pose(boxes: Sequence[OrientedBox], area: Area, rng: np.random.Generator) -> Transform:
    """Return ``T_world_truck`` somewhere along ``area``, or facing one of its long sides from near it."""
    corners = np.concatenate([box.corners() for box in boxes])
    x, y = rng.uniform(area.x_min, area.x_max), rng.uniform(area.y_min, area.y_max)
    turn = rng.normal(0.0, _HEADING_SPREAD)
    if rng.random() < _ALONG_FRACTION:
        turn += np.pi * rng.integers(2)
    else:
        side = 1.0 if rng.random() < 0.5 else -1.0
        gap = rng.uniform(*_BEFORE_SIDE) + float(corners[:, 0].max())
        turn += side * np.pi / 2
        y = area.y_max - gap if side > 0 else area.y_min + gap
    return make_transform(rotation_z(turn), np.array([x, y, 0.0]))
