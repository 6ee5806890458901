"""Unit loads in the slots of a rack, short side out, each a little off and a little turned; film torn off them."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Annotated

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.obstacles import WRAPS
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.site import Slot
from warehouse_sim.scene.loads.unit_load import UnitLoad, UnitLoadConfig, build_unit_load, jitter_scale, space_on
from warehouse_sim.scene.packing.contents import one_article

_CLEARANCE = 0.01
"""Least distance between two loads or a load and the rack (m)."""
_TRIES, _BAY_TRIES, _LOAD_TRIES = 50, 10, 3
_REACH = 4.0
"""Solids further than this (m) from every slot of a bay touch no load of the bay."""


@dataclass(frozen=True)
@ranged
class ShelvingConfig:
    """How pallets stand in their slots."""

    empty_slot_fraction: Fraction = 0.35
    """Fraction of the slots left free, 0-1; below 1 at least one slot is taken."""
    lateral_mm: Annotated[Distribution, Range(-200, 200, "mm")] = field(
        default=Distribution.normal(0.0, 12.0, -40.0, 40.0)
    )
    """Shift of a pallet along the beams (mm), -200 to 200."""
    depth_mm: Annotated[Distribution, Range(-75, 75, "mm")] = field(default=Distribution.normal(0.0, 20.0, -50.0, 50.0))
    """Shift of a pallet into the rack (mm), -75 to 75 so that it stays on both beams."""
    yaw_deg: Annotated[Distribution, Range(-20, 20, "deg")] = field(default=Distribution.normal(0.0, 2.5, -6.0, 6.0))
    """Turn of a pallet about the vertical against its slot (deg), -20 to 20."""

    heavier_below: bool = False
    """Whether the loads drawn for slots above each other are sorted: the heavier ones stand below, as they should."""
    one_kind_fraction: Fraction = 0.0
    """Fraction of the lanes of drive-in racks that hold one article on one type of pallet, 0-1."""
    hanging_film: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Loads on beams with torn film that hangs down before what is below, a whole number 0-20."""


def fill_rack(
    draft: SceneDraft, slots: Sequence[Slot], config: ShelvingConfig, loads: UnitLoadConfig, rng: np.random.Generator
) -> None:
    """Put unit loads into a fraction of the slots, of which there may be none.

    Raises:
        PlacementError: A bay's pallets fit in no try, or no carton fits under the beam above.
    """
    if not slots:
        return
    taken_fraction = 1.0 - config.empty_slot_fraction
    count = max(1, round(taken_fraction * len(slots))) if taken_fraction else 0
    taken = _from_the_far_end(slots, [slots[index] for index in np.sort(rng.permutation(len(slots))[:count])])
    structure = draft.solids().boxes
    first = sorted_loads(taken, loads, rng) if config.heavier_below else {}
    # Loads of other bays and levels are behind an upright or a beam, so each bay is filled for itself.
    for bay, members in groupby(taken, key=lambda slot: slot.bay):
        bay_slots = list(members)
        kind = loads
        if bay_slots[0].in_line and rng.random() < config.one_kind_fraction:
            kind = one_kind(min(slot.headroom for slot in bay_slots), bay_slots[0].footprint, loads, rng)
        sampled = [first[slot] for slot in bay_slots] if first else None
        for load, T_world_load in _fill_bay(bay, bay_slots, structure, config, kind, rng, sampled):
            load.add_to(draft, T_world_load)


def _from_the_far_end(slots: Sequence[Slot], taken: Sequence[Slot]) -> list[Slot]:
    """Return as many slots of each bay as are ``taken``; of a lane those at its far end, as trucks fill it."""
    chosen: list[Slot] = []
    for bay, members in groupby(taken, key=lambda slot: slot.bay):
        bay_slots = list(members)
        if bay_slots[0].in_line:
            bay_slots = [slot for slot in slots if slot.bay == bay][-len(bay_slots) :]
        chosen += bay_slots
    return chosen


def sorted_loads(slots: Sequence[Slot], loads: UnitLoadConfig, rng: np.random.Generator) -> dict[Slot, UnitLoad]:
    """Draw a load for each slot; among slots above each other the heaviest that fits stands lowest."""
    found: dict[Slot, UnitLoad] = {}
    columns: dict[tuple[float, float], list[Slot]] = defaultdict(list)
    for slot in slots:
        columns[round(float(slot.T_world_slot[0, 3]), 3), round(float(slot.T_world_slot[1, 3]), 3)].append(slot)
    for column in columns.values():
        sampled = [build_unit_load(slot.headroom, loads, rng, slot.footprint, slot.most_mass) for slot in column]
        upwards = sorted(column, key=lambda slot: float(slot.T_world_slot[2, 3]))
        by_mass = sorted(sampled, key=lambda load: -load.mass)
        fits = all(
            load.height <= slot.headroom and load.mass <= slot.most_mass
            for slot, load in zip(upwards, by_mass, strict=True)
        )
        found |= zip(upwards if fits else column, by_mass if fits else sampled, strict=True)
    return found


def one_kind(
    headroom: float, footprint: tuple[float, float] | None, loads: UnitLoadConfig, rng: np.random.Generator
) -> UnitLoadConfig:
    """Return ``loads`` with one article on one type of pallet for slots of ``headroom`` (m) and ``footprint`` (m)."""
    names = [
        name
        for name in loads.pallets
        if footprint is None or np.all(catalog_object(name).size[:2] <= np.array(footprint) + 1e-6)
    ]
    if not names:
        raise PlacementError(f"none of the recipe's pallets fits a lane's {footprint} m; list a smaller one")
    name = str(rng.choice(names))
    space = space_on(catalog_object(name), headroom)
    return replace(one_article(space, loads, rng), pallets=(name,))


def _fill_bay(
    bay: int,
    slots: list[Slot],
    structure: BoxStack,
    config: ShelvingConfig,
    loads: UnitLoadConfig,
    rng: np.random.Generator,
    first: list[UnitLoad] | None = None,
) -> list[tuple[UnitLoad, Transform]]:
    """Draw neighbouring loads, ``first`` those given, and their poses; loads that fit in no try are sampled again.

    What is sampled again is no carrier of its own: those on pallets of 1,000 mm along the beams leave no room for
    three.
    """
    to_slots = [structure.distances_to(slot.T_world_slot[:3, 3]) for slot in slots]
    near = structure.subset(np.min(to_slots, axis=0) < _REACH)
    for _ in range(_LOAD_TRIES):
        sampled = first or [
            build_unit_load(slot.headroom, loads, rng, slot.footprint, slot.most_mass) for slot in slots
        ]
        first, loads = None, replace(loads, carrier_fraction=0.0)
        for _ in range(_BAY_TRIES):
            poses = _place_all(slots, sampled, near, config, rng)
            if poses is not None:
                return list(zip(sampled, poses, strict=True))
    raise PlacementError(
        f"no room for {len(slots)} pallets in bay {bay} with {_LOAD_TRIES} draws of loads and {_BAY_TRIES} x {_TRIES} "
        "tries of each; lower shelving.yaw_deg or shelving.lateral_mm, or take narrower loads"
    )


def _place_all(
    slots: list[Slot], sampled: list[UnitLoad], structure: BoxStack, config: ShelvingConfig, rng: np.random.Generator
) -> list[Transform] | None:
    """Draw the poses of neighbouring loads one after the other; None for a dead end."""
    poses: list[Transform] = []
    envelopes: list[OrientedBox] = []
    for slot, load in zip(slots, sampled, strict=True):
        T_world_load = _place(slot, load, structure, BoxStack.of(envelopes), config, rng)
        if T_world_load is None:
            return None
        poses.append(T_world_load)
        envelopes.append(load.envelope.placed(T_world_load))
    return poses


def _place(
    slot: Slot,
    load: UnitLoad,
    structure: BoxStack,
    neighbours: BoxStack,
    config: ShelvingConfig,
    rng: np.random.Generator,
) -> Transform | None:
    for number in range(_TRIES):
        # The slot's x points into the rack, its y along the beams. Where it is tight, pallets stand straighter.
        scale = jitter_scale(number, _TRIES)
        shift = scale * np.array([config.depth_mm.sample(rng), config.lateral_mm.sample(rng), 0.0]) / 1000
        turn = scale * np.deg2rad(config.yaw_deg.sample(rng)) + np.pi * rng.integers(2)
        T_world_load = slot.T_world_slot @ make_transform(rotation_z(turn), shift)
        box = load.envelope.placed(T_world_load)
        if structure.clear_of(box, _CLEARANCE) and neighbours.clear_of(box, _CLEARANCE):
            return T_world_load
    return None


_FILM_ABOVE = 0.9
"""Loads lower than this (m) are not on a rack's beam, or too low for film to hang from."""
_FILM_AIR = 0.01
"""Distance of the film from the load's front (m)."""
_FILM_ASIDE = 0.25
"""How far to both sides of the load's middle it hangs (m)."""


def hang_film(draft: SceneDraft, count: int, area: Area, rng: np.random.Generator) -> None:
    """Hang film from up to ``count`` loads that stand high enough beside the aisle ``area``; it belongs to its load."""
    pallets = [
        item
        for item in draft.instances
        if draft.models[item.model].class_name == "pallet" and item.T_world_object[2, 3] > _FILM_ABOVE
    ]
    for index in rng.permutation(len(pallets))[:count]:
        pallet, model = pallets[index], draft.models[pallets[index].model]
        fitting = [name for name in WRAPS if catalog_object(name).size[2] < pallet.T_world_object[2, 3] - 0.1]
        film = catalog_object(str(rng.choice(fitting)))
        # Towards the aisle: -y for what stands on the front side, +y for the side opposite.
        side = -1.0 if pallet.T_world_object[1, 3] > area.y_max else 1.0
        reach = np.abs(pallet.T_world_object[1, :2]) @ model.size[:2] / 2
        x = pallet.T_world_object[0, 3] + rng.uniform(-_FILM_ASIDE, _FILM_ASIDE)
        y = pallet.T_world_object[1, 3] + side * (reach + _FILM_AIR + film.size[0] / 2)
        z = pallet.T_world_object[2, 3] + model.size[2] / 2 - film.size[2] / 2
        T_world_film = make_transform(rotation_z(side * np.pi / 2), np.array([x, y, z]))
        draft.add(film, T_world_film, pallet.group, fixed=True)
