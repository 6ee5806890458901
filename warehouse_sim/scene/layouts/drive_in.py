"""Drive-in racks: lanes between frames in which pallets stand on rails, one behind the other, long side out."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.pallet_racks import FRAME_DEPTH, FRAME_HEIGHTS, LANE_WIDTH, PLACE_PITCH, RAIL_HEIGHT
from warehouse_sim.catalog.racks.upright import UPRIGHT_WIDTH
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.draft import HALF_TURN, SceneDraft
from warehouse_sim.scene.layouts.rack_fittings import add_upright_guards
from warehouse_sim.scene.layouts.site import Layout, Side, Slot

_PITCH = LANE_WIDTH + UPRIGHT_WIDTH
"""Distance from lane to lane (m)."""
_FRAME_PITCH = 1.5
"""Distance from frame to frame along a lane (m), at most."""
_ABOVE_LOAD = 0.15
"""Free height between a load and the rail above it (m)."""
_TIE = 0.12
"""How far under the top of the frames the ties across the lanes are (m)."""
_FOOTPRINT = (1.2, 0.8)
"""Edges of the pallets across and along a lane (m): smaller ones would fall between the rails."""


@dataclass(frozen=True)
@ranged
class DriveInConfig(Layout):
    """Lanes of rails; trucks drive in, so that a lane is filled from its far end. List EPAL 1 pallets only."""

    kind: ClassVar[str] = "drive_in"

    lanes: Annotated[int, Range(1, 20)] = 7
    """Lanes side by side on a side, 1-20."""
    lane_depth: Annotated[int, Range(3, 12)] = 5
    """Pallets one behind the other, 3-12."""
    levels: Annotated[int, Range(1, 5)] = 3
    """Pallets above each other, the ones on the floor included, as many as the roof leaves room for, 1-5."""
    level_pitch: Annotated[float, Range(0.9, 2.4, "m")] = 1.6
    """Distance from level to level (m), 0.9-2.4."""
    sides: Literal["one", "both"] = "one"
    """Racks on one side of the aisle, with a wall behind, or on both."""

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and away from it (m)."""
        return self.lanes * _PITCH, self.lane_depth * PLACE_PITCH

    def under(self, clear_height: float) -> "DriveInConfig":
        """Return the rack with as many levels as leave room for the frames; at least one."""
        highest = max(height for height in FRAME_HEIGHTS.values() if height <= clear_height)
        fitting = int((highest - _TIE - _ABOVE_LOAD) / self.level_pitch)
        return replace(self, levels=max(1, min(self.levels, fitting)))

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add frames, rails and ties; the slots of a lane's level are one bay, the aisle's end first."""
        frame, height = self._frame()
        count = 1 + int(np.ceil((self.depth - FRAME_DEPTH) / _FRAME_PITCH))
        rows = [float(y) for y in np.linspace(FRAME_DEPTH / 2, self.depth - FRAME_DEPTH / 2, count)]
        for number in range(self.lanes + 1):
            x = (number - self.lanes / 2) * _PITCH
            for y in rows:
                draft.put(frame, (x, y, height / 2), T_world_side)
        slots: list[Slot] = []
        for lane in range(self.lanes):
            x = (lane - (self.lanes - 1) / 2) * _PITCH
            for y in rows:
                front = y - FRAME_DEPTH / 2 + 0.04
                draft.add(
                    "drive_in_tie", T_world_side @ make_transform(translation=np.array([x, front, height - _TIE]))
                )
            for level in range(self.levels):
                bay = first_bay + lane * self.levels + level
                slots += self._add_level(draft, T_world_side, x, level, bay)
        xs = [(number - self.lanes / 2) * _PITCH for number in range(self.lanes + 1)]
        add_upright_guards(draft, xs, T_world_side)
        return Side(slots=slots)

    def _frame(self) -> tuple[str, float]:
        """Return name and height (m) of the lowest frames that reach over the loads; the highest where none does."""
        needed = self.levels * self.level_pitch + _TIE + _ABOVE_LOAD
        found = [(name, height) for name, height in FRAME_HEIGHTS.items() if height >= needed]
        return found[0] if found else list(FRAME_HEIGHTS.items())[-1]

    def _add_level(self, draft: SceneDraft, T_world_side: Transform, x: float, level: int, bay: int) -> list[Slot]:
        """Add the rails of one level of the lane in the middle of ``x`` (m); return its slots."""
        top = level * self.level_pitch
        size = catalog_object("drive_in_rail").size
        slots = []
        for place in range(self.lane_depth):
            y = (place + 0.5) * PLACE_PITCH
            for side in (-1.0, 1.0) if level else ():
                draft.put(
                    "drive_in_rail",
                    (x + side * (LANE_WIDTH - size[0]) / 2, y, top - RAIL_HEIGHT + size[2] / 2),
                    T_world_side,
                    rotation=None if side < 0 else HALF_TURN,
                )
            slots.append(
                Slot(
                    T_world_side @ make_transform(translation=np.array([x, y, top])),
                    headroom=self.level_pitch - RAIL_HEIGHT - _ABOVE_LOAD,
                    bay=bay,
                    footprint=_FOOTPRINT,
                    in_line=True,
                )
            )
        return slots
