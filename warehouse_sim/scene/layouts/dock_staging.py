"""A row of dock doors, and before each of them lanes where loads wait for their truck."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.dock import DOOR_SIZE, LEVELLER_SIZE, OPEN_DOOR_SIZE, SEAL_SIZE
from warehouse_sim.catalog.building.shell import MODULE_LENGTH, WALL_SIZE
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.building.floor import mark_line
from warehouse_sim.scene.building.hall import module_x
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.block_storage import floor_lanes
from warehouse_sim.scene.layouts.site import Layout, Side

_TRAILER_RISE = 0.005
"""How far a trailer's floor lies above the hall's (m), so that they do not share a plane."""
_LIP_ON_TRAILER = 0.15
"""How far the leveller's lip lies on a trailer's floor (m)."""
_STACK_HEIGHT = 2.6
"""Height that a stack may take (m)."""


@dataclass(frozen=True)
@ranged
class DockStagingConfig(Layout):
    """Doors in the wall of the front side, and the staging area before them."""

    kind: ClassVar[str] = "dock_staging"

    doors: Annotated[int, Range(1, 6)] = 4
    """Doors side by side, 6 m apart, 1-6."""
    open_fraction: Fraction = 0.5
    """Fraction of the doors that are open, 0-1."""
    trailer_fraction: Fraction = 1.0
    """Fraction of the open doors that have a trailer behind them, 0-1; at others the yard is seen
    (``hall.outdoors``)."""
    lanes_per_door: Annotated[int, Range(1, 4)] = 3
    """Staging lanes before each door, 1-4."""
    lane_depth: Annotated[int, Range(1, 8)] = 4
    """Loads one behind the other in a lane, 1-8."""
    lane_width: Annotated[float, Range(0.9, 2, "m")] = 1.25
    """Distance from the middle of a lane to the next (m), 0.9-2."""
    pitch: Annotated[float, Range(0.9, 2, "m")] = 1.45
    """Distance from load to load in a lane (m), 0.9-2."""
    apron: Annotated[float, Range(3.2, 8, "m")] = 4.0
    """Free floor between the lanes and the doors (m), 3.2-8: the levellers, and room to turn."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lanes_per_door * self.lane_width > MODULE_LENGTH:
            raise ValueError(
                f"{self.lanes_per_door} lanes of {self.lane_width} m do not fit the {MODULE_LENGTH} m of a door; "
                "lower lanes_per_door or lane_width"
            )

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and from there to the wall with the doors (m)."""
        return self.doors * MODULE_LENGTH, self.lane_depth * self.pitch + self.apron

    @property
    def gap(self) -> float:
        """None: the wall belongs to the layout."""
        return 0.0

    @property
    def door_modules(self) -> tuple[int, ...]:
        """The modules in the middle of the wall."""
        first = round(WALL_SIZE[0] / MODULE_LENGTH) // 2 - (self.doors + 1) // 2
        return tuple(range(first, first + self.doors))

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add doors, levellers, trailers and lines; the places are the lanes."""
        is_open = rng.permutation(self.doors) < round(self.open_fraction * self.doors)
        docked = is_open.copy()
        if self.trailer_fraction < 1.0:
            free = rng.permutation(np.flatnonzero(is_open))
            docked[free[round(self.trailer_fraction * len(free)) :]] = False
        lanes = []
        for module, opened, has_trailer in zip(self.door_modules, is_open, docked, strict=True):
            x = module_x(module)
            self._add_door(draft, T_world_side, x, bool(opened), bool(has_trailer))
            middles = [x + (i - (self.lanes_per_door - 1) / 2) * self.lane_width for i in range(self.lanes_per_door)]
            for edge in [middles[0] - self.lane_width / 2, *(middle + self.lane_width / 2 for middle in middles)]:
                mark_line(draft, T_world_side, (edge, 0.0), self.lane_depth * self.pitch, "y", "yellow")
            lanes += floor_lanes(T_world_side, middles, self.lane_depth, (self.pitch, self.lane_width), _STACK_HEIGHT)
        return Side(lanes=lanes)

    def _add_door(self, draft: SceneDraft, T_world_side: Transform, x: float, is_open: bool, has_trailer: bool) -> None:
        """Add a door to the opening at ``x``, with its leveller; an open one perhaps with a trailer in the seal."""

        def add(name: str, start: float, z: float = 0.0) -> None:
            """Add something that begins ``start`` (m) out of the wall's inner face, ``z`` (m) over the floor."""
            size = catalog_object(name).size
            draft.put(name, (x, self.depth + start + size[1] / 2, z + size[2] / 2), T_world_side)

        if not is_open:
            add("dock_door_closed", -DOOR_SIZE[1])
            add("dock_leveller", -LEVELLER_SIZE[1])
            return
        rear = WALL_SIZE[1] + SEAL_SIZE[1]
        add("dock_door_open", -OPEN_DOOR_SIZE[1])
        if not has_trailer:
            add("dock_leveller", -LEVELLER_SIZE[1])
            return
        add("dock_leveller", rear + _LIP_ON_TRAILER - LEVELLER_SIZE[1])
        add("trailer", rear, _TRAILER_RISE - _trailer_floor())
        add("dock_seal", WALL_SIZE[1])


def _trailer_floor() -> float:
    """Return the height of a trailer's floor above its underside (m): its lowest collision box."""
    model = catalog_object("trailer")
    floor = min(model.collision, key=lambda box: box.T_parent_box[2, 3])
    return float(floor.T_parent_box[2, 3] + floor.size[2] / 2 + model.size[2] / 2)
