"""A storage platform along the aisle: shelving under it and on it, a railing at its edge."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.small_parts import COLUMN_HEIGHT, DECK_TOP, PANEL, SHELF_SIZE
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.draft import HALF_TURN, SceneDraft
from warehouse_sim.scene.layouts.site import Layout, Side, Strip
from warehouse_sim.scene.layouts.small_parts import add_shelf_row

_FREE_EDGE = 0.35
"""How far behind the edge of the platform the first shelves stand (m): columns are there."""
_WALK = 0.9
"""Free width behind the railing (m)."""


@dataclass(frozen=True)
@ranged
class MezzanineConfig(Layout):
    """A platform of panels of 2.06 x 2.4 m. It has no place for pallets: give it another side, or staging."""

    kind: ClassVar[str] = "mezzanine"
    has_shelves: ClassVar[bool] = True

    panels: Annotated[int, Range(2, 16)] = 8
    """Panels along the aisle, 2-16."""
    panel_rows: Annotated[int, Range(1, 4)] = 2
    """Panels away from the aisle, 1-4."""
    fill: Fraction = 0.85
    """Fraction of the shelves' width that is taken, 0-1."""
    goods_fraction: Fraction = 0.0
    """Fraction of the shelves that hold goods of your own (``loads.goods``), one article a shelf, 0-1."""

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and away from it (m)."""
        return self.panels * PANEL[0], self.panel_rows * PANEL[1]

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the platform and the shelving; there are no places for pallets."""
        xs = [(index - (self.panels - 1) / 2) * PANEL[0] for index in range(self.panels)]
        for x in xs:
            for row in range(self.panel_rows):
                draft.put("platform_panel", (x, (row + 0.5) * PANEL[1], COLUMN_HEIGHT + PANEL[2] / 2), T_world_side)
            railing = catalog_object("platform_railing").size
            draft.put("platform_railing", (x, railing[1] / 2, DECK_TOP + railing[2] / 2), T_world_side)
        self._add_columns(draft, T_world_side)
        bays = int((self.length - 0.3) / SHELF_SIZE[0])
        strips: list[Strip] = []
        for front, floor in ((_FREE_EDGE, 0.0), (_WALK, DECK_TOP)):
            for number, y in enumerate(np.arange(front, self.depth - SHELF_SIZE[1], SHELF_SIZE[1] + 0.5)):
                turned = number % 2 == 1
                at = np.array([0.0, y + (SHELF_SIZE[1] if turned else 0.0), floor])
                T_side_row = make_transform(HALF_TURN if turned else None, at)
                strips += add_shelf_row(draft, T_world_side @ T_side_row, bays, self.fill, rng, self.goods_fraction)
        return Side(strips=strips)

    def _add_columns(self, draft: SceneDraft, T_world_side: Transform) -> None:
        """Add columns under the platform's front edge, at every other panel's joint and at both ends."""
        half = self.length / 2
        inner = catalog_object("platform_column").size[0] / 2
        xs = [-half + inner, *(-half + index * PANEL[0] for index in range(2, self.panels, 2)), half - inner]
        for x in xs:
            draft.put("platform_column", (x, inner, COLUMN_HEIGHT / 2), T_world_side)
