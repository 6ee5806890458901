"""Block storage: pallets stacked on the floor in lanes that end at the aisle, without any rack."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.building.floor import mark_line
from warehouse_sim.scene.draft import QUARTER_TURN, SceneDraft
from warehouse_sim.scene.layouts.site import Lane, Layout, Side

PLAY = 0.06
"""Free space that a place keeps around the largest pallet it is made for (m)."""


@dataclass(frozen=True)
@ranged
class BlockStorageConfig(Layout):
    """Lanes of floor storage along the aisle."""

    kind: ClassVar[str] = "block_storage"

    lanes: Annotated[int, Range(1, 32)] = 10
    """Lanes side by side on a side, 1-32."""
    lane_depth: Annotated[int, Range(1, 8)] = 4
    """Stacks one behind the other in a lane, 1-8."""
    lane_width: Annotated[float, Range(0.7, 2, "m")] = 1.1
    """Distance from the middle of a lane to the next (m), 0.7-2."""
    stack_pitch: Annotated[float, Range(0.7, 2, "m")] = 1.3
    """Distance from stack to stack in a lane (m), 0.7-2."""
    clear_height: Annotated[float, Range(1, 7, "m")] = 5.0
    """Height that stacks may take (m), 1-7."""
    sides: Literal["one", "both"] = "one"
    """Lanes on one side of the aisle or on both."""

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and away from it (m)."""
        return self.lanes * self.lane_width, self.lane_depth * self.stack_pitch

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Mark the lanes on the floor; nothing else stands in a block."""
        middles = self.lane_middles()
        for x in [middles[0] - self.lane_width / 2, *(middle + self.lane_width / 2 for middle in middles)]:
            mark_line(draft, T_world_side, (x, 0.0), self.depth, "y", "white")
        return Side(
            lanes=floor_lanes(
                T_world_side, middles, self.lane_depth, (self.stack_pitch, self.lane_width), self.clear_height
            )
        )

    def lane_middles(self) -> list[float]:
        """Return x of each lane's middle (m)."""
        return [(index - (self.lanes - 1) / 2) * self.lane_width for index in range(self.lanes)]


def floor_lanes(
    T_world_side: Transform, middles: Sequence[float], count: int, size: tuple[float, float], clear_height: float
) -> list[Lane]:
    """Return lanes with middles at x = ``middles`` (m) and ``count`` places each, ``size`` along and across (m)."""
    pitch, width = size
    return [
        Lane(
            tuple(
                T_world_side @ make_transform(QUARTER_TURN, np.array([x, (index + 0.5) * pitch, 0.0]))
                for index in range(count)
            ),
            clear_height,
            (pitch - PLAY, width - PLAY),
        )
        for x in middles
    ]
