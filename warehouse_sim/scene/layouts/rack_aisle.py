"""A selective rack along an aisle, on one side or both.

World: the aisle runs along x, centred on x = 0; the first rack's front is the plane y = 0 and the rack extends to
positive y; the aisle is the strip from y = -width to 0. The floor is z = 0.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from warehouse_sim.catalog.building import FLOOR_SIZE, WALL_SIZE
from warehouse_sim.catalog.pallets import HEIGHT as PALLET_HEIGHT
from warehouse_sim.catalog.pallets import WIDTH as PALLET_WIDTH
from warehouse_sim.catalog.racks import (
    BAY_WIDTH,
    BEAM_DEPTH,
    BEAM_HEIGHT,
    CONNECTOR_HEIGHT,
    FRAME_DEPTH,
    FRAME_HEIGHTS,
    UPRIGHT_WIDTH,
)
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.scene.draft import Area, SceneDraft

BAY_PITCH = BAY_WIDTH + UPRIGHT_WIDTH
"""Distance between the axes of neighbouring frames (m)."""
SLOTS_PER_BAY = 3
LOAD_CLEARANCE = 0.1
"""Free height between a load and the beam above it (m)."""
_HEADROOM_ABOVE_TOP = 1.3
"""Height that a load on the top level may take, pallet included (m)."""
_FRAME_OVER_TOP_BEAM = 0.5
"""End frames rise at least this far above the top beam (m)."""
_WALL_GAP = 0.4
"""Free space between the back of a rack and the wall (m)."""
_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_HALF_TURN = _QUARTER_TURN @ _QUARTER_TURN


@dataclass(frozen=True)
class RackAisleConfig:
    """Size of the rack and of the aisle in front of it."""

    bays: int = 4
    """Bays of 2.7 m on a side, 1-12."""
    beam_levels: tuple[float, ...] = (1.45, 2.9)
    """Heights of the beams' tops above the floor (m), rising, each at least 0.6 above the one before, at most 6."""
    ground_level: bool = True
    """Whether pallets also stand on the floor inside the rack."""
    sides: Literal["one", "both"] = "one"
    """Racks on one side of the aisle, with a wall behind, or on both."""
    aisle_width: float = 9.5
    """Free floor in front of the rack (m), 3-15; an observation needs its distance and about 1 m more."""

    def __post_init__(self) -> None:
        if not 1 <= self.bays <= 12:
            raise ValueError(f"bays must be 1-12, found {self.bays}")
        if not 3.0 <= self.aisle_width <= 15.0:
            raise ValueError(f"aisle_width must be 3-15 m, found {self.aisle_width}")
        steps = np.diff([0.0, *self.beam_levels])
        if len(steps) and (steps.min() < 0.6 or max(self.beam_levels) > 6.0):
            raise ValueError(
                f"beam_levels must rise by at least 0.6 m from the floor and end by 6 m, found {list(self.beam_levels)}"
            )
        if not self.beam_levels and not self.ground_level:
            raise ValueError("beam_levels is empty and ground_level is false: no slot is left for a pallet")


@dataclass(frozen=True, eq=False)
class Slot:
    """A place for one pallet, short side out."""

    T_world_slot: Transform
    """On the supporting surface under the pallet's centre; x into the rack, z up."""
    headroom: float
    """Height from the supporting surface that the load may take, pallet included (m)."""
    bay: int
    """Number of the bay and level; slots of one bay are neighbours."""


def aisle_area(config: RackAisleConfig) -> Area:
    """Return the free floor in front of the rack (m)."""
    half = config.bays * BAY_PITCH / 2
    return Area(-half, half, -config.aisle_width, 0.0)


def build_rack_aisle(draft: SceneDraft, config: RackAisleConfig) -> list[Slot]:
    """Add floor, wall and racks to ``draft`` and return the slots, bay by bay."""
    _build_hall(draft, config)
    slots = _build_rack(draft, config, np.eye(4), first_bay=0)
    if config.sides == "both":
        T_world_rack = make_transform(_HALF_TURN, np.array([0.0, -config.aisle_width, 0.0]))
        slots += _build_rack(draft, config, T_world_rack, first_bay=len(slots))
    return slots


def _build_hall(draft: SceneDraft, config: RackAisleConfig) -> None:
    """Add the slab and a wall on each of its sides; those behind a rack stand close to it."""
    draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -FLOOR_SIZE[2] / 2])))
    behind = FRAME_DEPTH + _WALL_GAP + WALL_SIZE[1] / 2
    side = (FLOOR_SIZE[0] - WALL_SIZE[1]) / 2
    opposite = -config.aisle_width - behind if config.sides == "both" else -(FLOOR_SIZE[1] - WALL_SIZE[1]) / 2
    for x, y, rotation in ((0, behind, None), (0, opposite, None), (-side, 0, _QUARTER_TURN), (side, 0, _QUARTER_TURN)):
        draft.add("wall", make_transform(rotation, np.array([x, y, WALL_SIZE[2] / 2])))


def _build_rack(draft: SceneDraft, config: RackAisleConfig, T_world_rack: Transform, first_bay: int) -> list[Slot]:
    """Add one rack whose front is the plane y = 0 of its own frame; return its slots."""
    top = max(config.beam_levels, default=1.0)
    frame, height = next(
        (name, height) for name, height in FRAME_HEIGHTS.items() if height >= top + _FRAME_OVER_TOP_BEAM
    )
    left = -config.bays * BAY_PITCH / 2
    for index in range(config.bays + 1):
        at = np.array([left + index * BAY_PITCH, FRAME_DEPTH / 2, height / 2])
        draft.add(frame, T_world_rack @ make_transform(translation=at))
    slots = []
    levels = ([0.0] if config.ground_level else []) + list(config.beam_levels)
    for bay in range(config.bays):
        x = left + (bay + 0.5) * BAY_PITCH
        for level, z in enumerate(levels):
            if z > 0.0:
                _add_beams(draft, T_world_rack, x, z)
            above = [other for other in config.beam_levels if other > z]
            free = above[0] - BEAM_HEIGHT - LOAD_CLEARANCE - z if above else _HEADROOM_ABOVE_TOP
            slots += _bay_slots(T_world_rack, x, z, free, first_bay + bay * len(levels) + level)
    return slots


def _add_beams(draft: SceneDraft, T_world_rack: Transform, x: float, top: float) -> None:
    for y in (BEAM_DEPTH / 2, FRAME_DEPTH - BEAM_DEPTH / 2):
        at = np.array([x, y, top - CONNECTOR_HEIGHT / 2])
        draft.add("rack_beam_2700", T_world_rack @ make_transform(translation=at))


def _bay_slots(T_world_rack: Transform, x: float, z: float, headroom: float, bay: int) -> list[Slot]:
    if headroom < PALLET_HEIGHT:
        return []
    # Equal gaps of 75 mm between uprights and pallets and from pallet to pallet.
    pitch = PALLET_WIDTH + (BAY_WIDTH - SLOTS_PER_BAY * PALLET_WIDTH) / (SLOTS_PER_BAY + 1)
    offsets = (np.arange(SLOTS_PER_BAY) - (SLOTS_PER_BAY - 1) / 2) * pitch
    return [
        Slot(T_world_rack @ make_transform(_QUARTER_TURN, np.array([x + dx, FRAME_DEPTH / 2, z])), headroom, bay)
        for dx in offsets
    ]
