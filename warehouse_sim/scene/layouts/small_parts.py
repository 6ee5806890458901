"""Shelving for small parts along a narrow aisle, in rows back to back, with bins, euro containers and cartons."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.catalog.racks.small_parts import SHELF_SIZE
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.draft import HALF_TURN, SceneDraft
from warehouse_sim.scene.layouts.shelf_rows import add_shelf_row
from warehouse_sim.scene.layouts.site import Layout, Side, Strip

_BETWEEN = 0.06
"""Free space between rows back to back (m)."""
_AISLE = 1.1
"""Width of the aisles between the rows behind (m)."""


@dataclass(frozen=True)
@ranged
class SmallPartsConfig(Layout):
    """Rows of shelves; what stands in them is fixed. It has no place for pallets: give it another side, or staging."""

    kind: ClassVar[str] = "small_parts"

    bays: Annotated[int, Range(2, 30)] = 12
    """Bays of 1.03 m in a row, 2-30."""
    rows: Annotated[int, Range(1, 6)] = 2
    """Rows on a side, 1-6, two and two back to back."""
    fill: Fraction = 0.85
    """Fraction of the shelves' width that is taken, 0-1."""
    goods_fraction: Fraction = 0.0
    """Fraction of the shelves that hold goods of your own (``loads.goods``), one article a shelf, 0-1."""
    sides: Literal["one", "both"] = "one"
    """Shelves on one side of the aisle, with a wall behind, or on both."""

    @property
    def length(self) -> float:
        """Extent along the aisle (m)."""
        return self.bays * SHELF_SIZE[0]

    @property
    def depth(self) -> float:
        """Depth of all rows (m)."""
        return self._front(self.rows - 1) + SHELF_SIZE[1]

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the rows; there are no places for pallets."""
        strips: list[Strip] = []
        for row in range(self.rows):
            turned = row % 2 == 1
            at = np.array([0.0, self._front(row) + (SHELF_SIZE[1] if turned else 0.0), 0.0])
            T_side_row = make_transform(HALF_TURN if turned else None, at)
            strips += add_shelf_row(draft, T_world_side @ T_side_row, self.bays, self.fill, rng, self.goods_fraction)
        return Side(strips=strips)

    @staticmethod
    def _front(row: int) -> float:
        """Return y (m) of the nearer face of a row."""
        pairs, second = divmod(row, 2)
        return pairs * (2 * SHELF_SIZE[1] + _BETWEEN + _AISLE) + second * (SHELF_SIZE[1] + _BETWEEN)
