"""A pallet conveyor along the aisle, from which a truck takes loads, with one for cartons above and behind it."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from warehouse_sim.catalog.building.conveyor import CONVEYORS
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.building.floor import mark_line
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Layout, Side, Slot, Strip

_PALLETS, _CARTONS = "pallet_conveyor", "roller_conveyor"
_BACK = 1.6
"""Distance between the middles of the two conveyors (m)."""
_LINE = 0.35
"""Distance of the line that keeps people off from the conveyor (m)."""
_HEADROOM = 2.0
"""Height that a load may take, pallet included (m)."""


@dataclass(frozen=True)
@ranged
class ConveyorPickupConfig(Layout):
    """Length of the conveyors and how loads follow each other."""

    kind: ClassVar[str] = "conveyor_pickup"
    has_shelves: ClassVar[bool] = True

    segments: Annotated[int, Range(1, 12)] = 6
    """Segments of 2.4 m, 1-12."""
    pitch: Annotated[float, Range(1.3, 4, "m")] = 1.6
    """Distance from load to load (m), 1.3-4."""
    carton_line: bool = True
    """Whether a conveyor for cartons runs behind."""
    carton_fill: Fraction = 0.0
    """Fraction of that conveyor's length that cartons (``loads.cartons``) take, 0-1."""
    goods_fraction: Fraction = 0.0
    """Fraction of those that are goods of your own (``loads.goods``) instead, 0-1."""

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and away from it (m)."""
        pallets = CONVEYORS[_PALLETS]
        return self.segments * pallets.length, pallets.width + (_BACK if self.carton_line else 0.0)

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the conveyors; their places lie lengthwise on the pallets' one, its whole length one bay."""
        y = CONVEYORS[_PALLETS].width / 2
        self._add_line(draft, T_world_side, _PALLETS, y)
        if self.carton_line:
            self._add_line(draft, T_world_side, _CARTONS, y + _BACK)
        mark_line(draft, T_world_side, (-self.length / 2, -_LINE), self.length, "x", "yellow")
        count = int((self.length - 1.3) / self.pitch) + 1
        height = CONVEYORS[_PALLETS].height
        places = [np.array([(index - (count - 1) / 2) * self.pitch, y, height]) for index in range(count)]
        slots = [Slot(T_world_side @ make_transform(translation=at), _HEADROOM, first_bay) for at in places]
        if not self.carton_line or self.carton_fill == 0.0:
            return Side(slots=slots)
        rollers = CONVEYORS[_CARTONS]
        T_side_strip = make_transform(translation=np.array([0.0, y + _BACK - rollers.lane / 2, rollers.height]))
        goods = {"fill": self.carton_fill, "own_fraction": self.goods_fraction}
        strip = Strip(T_world_side @ T_side_strip, self.length, rollers.lane, 1.0, **goods, one_kind=False)
        return Side(slots=slots, strips=[strip])

    def _add_line(self, draft: SceneDraft, T_world_side: Transform, name: str, y: float) -> None:
        kind = CONVEYORS[name]
        count = int(self.length / kind.length + 1e-6)
        for index in range(count):
            draft.put(name, ((index - (count - 1) / 2) * kind.length, y, kind.height / 2), T_world_side)
