"""Unit loads in the slots of a rack, short side out, each a little off and a little turned."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Annotated

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.ranges import Range, Share, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Slot
from warehouse_sim.scene.placing import jitter_scale
from warehouse_sim.scene.unit_load import UnitLoad, UnitLoadConfig, build_unit_load

_CLEARANCE = 0.01
"""Least distance between two loads or a load and the rack (m)."""
_TRIES, _BAY_TRIES, _LOAD_TRIES = 50, 10, 3
_REACH = 4.0
"""Solids further than this (m) from every slot of a bay touch no load of the bay."""


@dataclass(frozen=True)
@ranged
class ShelvingConfig:
    """How pallets stand in their slots."""

    empty_slot_share: Share = 0.35
    """Share of the slots left free, 0-1; at least one slot is taken."""
    lateral_mm: Annotated[Distribution, Range(-200, 200, "mm")] = field(
        default=Distribution.normal(0.0, 12.0, -40.0, 40.0)
    )
    """Shift of a pallet along the beams (mm), -200 to 200."""
    depth_mm: Annotated[Distribution, Range(-75, 75, "mm")] = field(default=Distribution.normal(0.0, 20.0, -50.0, 50.0))
    """Shift of a pallet into the rack (mm), -75 to 75 so that it stays on both beams."""
    yaw_deg: Annotated[Distribution, Range(-20, 20, "deg")] = field(default=Distribution.normal(0.0, 2.5, -6.0, 6.0))
    """Turn of a pallet about the vertical against its slot (deg), -20 to 20."""

    hanging_film: Annotated[Distribution, Range(0, 20, whole=True)] = field(default=Distribution.constant(0))
    """Loads on beams with torn film that hangs down before what is below, a whole number 0-20."""


def fill_rack(
    draft: SceneDraft, slots: Sequence[Slot], config: ShelvingConfig, loads: UnitLoadConfig, rng: np.random.Generator
) -> None:
    """Put unit loads into a share of the slots, of which there may be none.

    Raises:
        PlacementError: A bay's pallets fit in no try, or no carton fits under the beam above.
    """
    if not slots:
        return
    count = max(1, round((1.0 - config.empty_slot_share) * len(slots)))
    taken = [slots[index] for index in np.sort(rng.permutation(len(slots))[:count])]
    structure = draft.solids().boxes
    # Loads of other bays and levels are behind an upright or a beam, so each bay is filled for itself.
    for bay, members in groupby(taken, key=lambda slot: slot.bay):
        bay_slots = list(members)
        for load, T_world_load in _fill_bay(bay, bay_slots, structure, config, loads, rng):
            load.add_to(draft, T_world_load)


def _fill_bay(
    bay: int,
    slots: list[Slot],
    structure: BoxStack,
    config: ShelvingConfig,
    loads: UnitLoadConfig,
    rng: np.random.Generator,
) -> list[tuple[UnitLoad, Transform]]:
    """Draw neighbouring loads and their poses; loads that fit in no try are drawn again."""
    to_slots = [structure.distances_to(slot.T_world_slot[:3, 3]) for slot in slots]
    near = structure.subset(np.min(to_slots, axis=0) < _REACH)
    for _ in range(_LOAD_TRIES):
        drawn = [build_unit_load(slot.headroom, loads, rng, slot.footprint) for slot in slots]
        for _ in range(_BAY_TRIES):
            poses = _place_all(slots, drawn, near, config, rng)
            if poses is not None:
                return list(zip(drawn, poses, strict=True))
    raise PlacementError(
        f"no room for {len(slots)} pallets in bay {bay} with {_LOAD_TRIES} draws of loads and {_BAY_TRIES} x {_TRIES} "
        "tries of each; lower shelving.yaw_deg or shelving.lateral_mm, or take narrower loads"
    )


def _place_all(
    slots: list[Slot], drawn: list[UnitLoad], structure: BoxStack, config: ShelvingConfig, rng: np.random.Generator
) -> list[Transform] | None:
    """Draw the poses of neighbouring loads one after the other; None for a dead end."""
    poses: list[Transform] = []
    envelopes: list[OrientedBox] = []
    for slot, load in zip(slots, drawn, strict=True):
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
        shift = scale * np.array([config.depth_mm.draw(rng), config.lateral_mm.draw(rng), 0.0]) / 1000
        turn = scale * np.deg2rad(config.yaw_deg.draw(rng)) + np.pi * rng.integers(2)
        T_world_load = slot.T_world_slot @ make_transform(rotation_z(turn), shift)
        box = load.envelope.placed(T_world_load)
        if structure.clear_of(box, _CLEARANCE) and neighbours.clear_of(box, _CLEARANCE):
            return T_world_load
    return None
