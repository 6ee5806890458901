"""Stacks of unit loads in the floor lanes of a layout, filled from the far end as a truck fills them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Lane
from warehouse_sim.scene.loads.unit_load import UnitLoad, UnitLoadConfig, build_unit_load, jitter_scale, space_on
from warehouse_sim.scene.packing.contents import one_article, that_carry
from warehouse_sim.scene.packing.pallet_choice import all_pallets, on_these, sample_carrier, sample_pallet
from warehouse_sim.schema import ObjectModel

STACKING_LOAD = 4000.0
"""What may stand on the lowest pallet of a stack (kg); EPAL's product sheet of the EPAL 1."""
_CLEARANCE = 0.01
"""Least distance between two stacks (m)."""
_TRIES, _STACK_TRIES = 50, 4
_REACH = 4.0
"""Stacks further than this (m) from a place do not obstruct it."""
_LEAST_HEADROOM = 0.6
"""A stack grows only while this much height is left for the next load (m)."""

_HIGH_STACK = 3
"""Stacks of so many loads are wrapped under the crush rule."""
_OFFSET_MM = Distribution.normal(0.0, 12.0, -35.0, 35.0)
"""Shift of a load against the one under it, along each axis (mm)."""


@dataclass(frozen=True)
@ranged
class LanesConfig:
    """How full lanes are and how carefully stacks stand in them."""

    fill: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.3, 1.0))
    """Fraction of a lane's places that are taken, from its far end, 0-1."""
    stack: Annotated[Distribution, Range(1, 4, whole=True)] = field(default=Distribution.uniform(1, 3))
    """Loads on each other, a whole number 1-4; what pallets and goods bear and the clear height limit it too."""
    one_kind_fraction: Fraction = 0.7
    """Fraction of the lanes that hold one article on one type of pallet, 0-1; the others hold what comes."""
    empties_fraction: Fraction = 0.1
    """Fraction of the lanes that hold stacks of empty pallets, 0-1."""
    empties: Annotated[Distribution, Range(1, 15, whole=True)] = field(default=Distribution.uniform(4, 10))
    """Pallets in a stack of empty ones, a whole number 1-15."""
    lateral_mm: Annotated[Distribution, Range(-200, 200, "mm")] = field(
        default=Distribution.normal(0.0, 15.0, -45.0, 45.0)
    )
    """Shift of a stack across its lane (mm), -200 to 200."""
    depth_mm: Annotated[Distribution, Range(-200, 200, "mm")] = field(
        default=Distribution.normal(0.0, 20.0, -60.0, 60.0)
    )
    """Shift of a stack along its lane (mm), -200 to 200."""
    yaw_deg: Annotated[Distribution, Range(-20, 20, "deg")] = field(default=Distribution.normal(0.0, 1.5, -4.0, 4.0))
    """Turn of a stack about the vertical against its lane (deg), -20 to 20."""


Stack = list[tuple[UnitLoad, Transform]]
"""Loads on each other with T_stack_load, the lowest first."""


def fill_lanes(
    draft: SceneDraft, lanes: Sequence[Lane], config: LanesConfig, loads: UnitLoadConfig, rng: np.random.Generator
) -> None:
    """Put stacks into the lanes.

    Raises:
        PlacementError: A stack fits in no try.
    """
    standing: list[OrientedBox] = []
    for number, lane in enumerate(lanes):
        count = round(config.fill.sample(rng) * len(lane.T_world_places))
        empty = rng.random() < config.empties_fraction
        stacked = config.stack.high > 1
        kind = _of_one_article(lane, loads, rng, stacked) if rng.random() < config.one_kind_fraction else loads
        kind = _of_one_carrier(lane, kind, rng)
        draw = _empty_stack if empty else _sample_stack
        for T_world_place in reversed(lane.T_world_places[len(lane.T_world_places) - count :]):
            aside = [np.linalg.norm(box.T_parent_box[:2, 3] - T_world_place[:2, 3]) for box in standing]
            near = BoxStack.of([box for box, distance in zip(standing, aside, strict=True) if distance < _REACH])
            for _ in range(_STACK_TRIES):
                stack = draw(lane, config, kind, rng)
                T_world_stack = _place(T_world_place, stack, near, config, rng)
                if T_world_stack is not None:
                    break
            else:
                raise PlacementError(
                    f"no room for a stack in lane {number} after {_STACK_TRIES} x {_TRIES} tries; lower lanes.yaw_deg "
                    "or lanes.lateral_mm, or widen the lanes"
                )
            for load, T_stack_load in stack:
                standing.append(load.envelope.placed(T_world_stack @ T_stack_load))
                load.add_to(draft, T_world_stack @ T_stack_load)


def _sample_stack(lane: Lane, config: LanesConfig, loads: UnitLoadConfig, rng: np.random.Generator) -> Stack:
    """Draw loads on equal pallets; each stands on a full and level top layer, and no goods bear more than they can."""
    wanted, rule = max(1, config.stack.sample_count(rng)), loads.stacking.crush_rule
    pallet = _choose_pallet(lane, loads, rng)
    top = on_these(loads, [pallet])
    level = replace(top.stacking, top_layer_fraction=Distribution.constant(1.0))
    full = replace(top, empty_fraction=0.0, mixed_fraction=0.0, stacking=level)
    if rule:
        full = that_carry(full, _deck(pallet))
        full = replace(full, height=Distribution.uniform((full.height.low + full.height.high) / 2, full.height.high))
    stack: Stack = []
    height, spare = 0.0, np.inf
    for number in range(wanted):
        headroom = lane.clear_height - height
        try:
            config_of = top if number == wanted - 1 else full
            load = build_unit_load(headroom, config_of, rng, lane.footprint, spare, on_floor=not stack)
        except PlacementError:
            if stack:
                break  # the stack ends where its goods are too high for the rest of the room, or too heavy
            raise
        T_stack_load = _on_top(height, rng, stacked=bool(stack))
        if stack and not (load.mass <= spare and _stands_on(stack[-1], load, T_stack_load) and _is_of(load, loads)):
            break
        if rule and stack and load.holds("drum") and not stack[-1][0].holds("drum"):
            break
        bearing = load.bearing_under_boards if rule else load.bearing
        spare = min(bearing, spare - load.mass if stack else STACKING_LOAD)
        stack.append((load, T_stack_load))
        height += load.height
        if lane.clear_height - height < _LEAST_HEADROOM:
            break
    if rule and sum(load.has_goods for load, _ in stack) >= _HIGH_STACK:
        return [(load.wrapped(loads.film, rng), T_stack_load) for load, T_stack_load in stack]
    return stack


def _is_of(load: UnitLoad, loads: UnitLoadConfig) -> bool:
    """Return whether a load is a carrier where the lane holds nothing else."""
    return loads.carrier_fraction < 1.0 or any(model.name in loads.carriers for model, _ in load.pieces)


def _stands_on(below: tuple[UnitLoad, Transform], load: UnitLoad, T_stack_load: Transform) -> bool:
    lower, T_stack_lower = below
    return lower.supports(load.pallet, invert(T_stack_lower) @ T_stack_load)


def _empty_stack(lane: Lane, config: LanesConfig, loads: UnitLoadConfig, rng: np.random.Generator) -> Stack:
    """Draw a stack of empty pallets of one kind."""
    bare = replace(on_these(loads, [_choose_pallet(lane, loads, rng)]), empty_fraction=1.0, carrier_fraction=0.0)
    stack: Stack = []
    height = 0.0
    for _ in range(max(1, config.empties.sample_count(rng))):
        load = build_unit_load(np.inf, bare, rng)
        stack.append((load, _on_top(height, rng, stacked=bool(stack))))
        height += load.height
    return stack


def _choose_pallet(lane: Lane, loads: UnitLoadConfig, rng: np.random.Generator) -> ObjectModel:
    """Draw a pallet that the lane is wide and its places are deep enough for."""
    try:
        return sample_pallet(loads, rng, lane.footprint)
    except PlacementError as problem:
        raise PlacementError(f"{problem}, or widen the lanes") from problem


def _deck(pallet: ObjectModel) -> tuple[float, float]:
    length, width, _ = pallet.size.tolist()
    return length, width


def _of_one_article(lane: Lane, loads: UnitLoadConfig, rng: np.random.Generator, stacked: bool) -> UnitLoadConfig:
    """Return ``loads`` with one article, in one pattern, on one type of pallet, as a lane holds it.

    Where loads are ``stacked``, the crush rule takes articles that carry a load.
    """
    pallet = _choose_pallet(lane, loads, rng)
    alike = [model for model in all_pallets(loads) if model.obj_id == pallet.obj_id]
    if loads.stacking.crush_rule and stacked:
        loads = that_carry(loads, _deck(pallet))
    return on_these(one_article(space_on(pallet, lane.clear_height), loads, rng), alike)


def _of_one_carrier(lane: Lane, loads: UnitLoadConfig, rng: np.random.Generator) -> UnitLoadConfig:
    """Return ``loads`` with one carrier alone in the recipe's fraction of the lanes, and with none in the others."""
    if loads.carrier_fraction <= 0.0:
        return loads
    if rng.random() < loads.carrier_fraction:
        sampled = sample_carrier(loads, rng, lane.clear_height, lane.footprint, STACKING_LOAD, on_floor=True)
        if sampled is not None:
            return replace(loads, carrier_fraction=1.0, carriers=(sampled[0].name,))
    return replace(loads, carrier_fraction=0.0)


def _on_top(height: float, rng: np.random.Generator, stacked: bool) -> Transform:
    """Return T_stack_load of a load at ``height`` (m): a little off and either end first."""
    shift = [_OFFSET_MM.sample(rng) / 1000, _OFFSET_MM.sample(rng) / 1000] if stacked else [0.0, 0.0]
    return make_transform(rotation_z(np.pi * rng.integers(2)), np.array([*shift, height]))


def _place(
    T_world_place: Transform, stack: Stack, others: BoxStack, config: LanesConfig, rng: np.random.Generator
) -> Transform | None:
    for number in range(_TRIES):
        # The place's x points into the lane, its y across it. Where it is tight, stacks stand straighter.
        scale = jitter_scale(number, _TRIES)
        shift = scale * np.array([config.depth_mm.sample(rng), config.lateral_mm.sample(rng), 0.0]) / 1000
        turn = scale * np.deg2rad(config.yaw_deg.sample(rng))
        T_world_stack = T_world_place @ make_transform(rotation_z(turn), shift)
        boxes = [load.envelope.placed(T_world_stack @ T_stack_load) for load, T_stack_load in stack]
        if all(others.clear_of(box, _CLEARANCE) for box in boxes):
            return T_world_stack
    return None
