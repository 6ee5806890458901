"""Shelving for small parts along a narrow aisle, in rows back to back, with bins, euro containers and cartons.

What stands in a row of shelving bays is fixed and at rest by construction: level on level shelves.
Frame of a row: x along it, its front at the plane y = 0, z up from the floor that it stands on.
"""

from dataclasses import dataclass
from functools import cache
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.racks.small_parts import BINS, SHELF_CLEARANCE, SHELF_SIZE, shelf_tops
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.draft import HALF_TURN, SceneDraft
from warehouse_sim.scene.layouts.site import Layout, Side, Strip
from warehouse_sim.schema import ObjectModel

_CLEAR = SHELF_SIZE[0] - 0.06
"""Width of a shelf between the posts (m)."""
_DEPTH = SHELF_SIZE[1] - 0.02
"""Depth of a shelf before the cross of bars (m)."""
_PLAY = (0.004, 0.05)
"""Least and largest gap between two things on a shelf (m)."""
_BEHIND_EDGE = (0.01, 0.04)
"""How far behind a shelf's front edge things stand (m)."""
_QUARTER_TURN = rotation_z(np.pi / 2)


def add_shelf_row(
    draft: SceneDraft,
    T_world_row: Transform,
    bays: int,
    fill: float,
    rng: np.random.Generator,
    own_fraction: float = 0.0,
) -> list[Strip]:
    """Add ``bays`` bays centred on x = 0 and fill ``fill`` (0-1) of each shelf, one kind of thing a shelf.

    Return the shelves; the fraction ``own_fraction`` (0-1) of them is left to goods of the user's own.
    """
    strips = []
    for bay in range(bays):
        x = (bay - (bays - 1) / 2) * SHELF_SIZE[0]
        draft.put("shelf_bay", (x, SHELF_SIZE[1] / 2, SHELF_SIZE[2] / 2), T_world_row)
        for top in shelf_tops()[:-1]:
            T_world_shelf = T_world_row @ make_transform(translation=np.array([x, 0.0, top]))
            is_own = own_fraction > 0.0 and bool(rng.random() < own_fraction)
            if not is_own:
                _fill_shelf(draft, T_world_shelf, fill, rng)
            strips.append(Strip(T_world_shelf, _CLEAR, _DEPTH, SHELF_CLEARANCE, fill if is_own else 0.0))
    return strips


def _fill_shelf(draft: SceneDraft, T_world_shelf: Transform, fill: float, rng: np.random.Generator) -> None:
    """Put things of one kind side by side, short side out where they are longer than wide."""
    kinds = _kinds()
    models = kinds[int(rng.integers(len(kinds)))]
    model = models[int(rng.integers(len(models)))]
    turned = model.size[0] > model.size[1] and model.size[0] <= SHELF_SIZE[1] - 0.06
    width, depth = (model.size[1], model.size[0]) if turned else (model.size[0], model.size[1])
    x = -_CLEAR / 2 + rng.uniform(*_PLAY)
    setback = rng.uniform(*_BEHIND_EDGE)
    while x + width <= _CLEAR / 2:
        if rng.random() < fill:
            shown = models[int(rng.integers(len(models)))] if len({item.size[1] for item in models}) == 1 else model
            draft.put(
                shown.name,
                (x + width / 2, setback + depth / 2 + rng.uniform(0.0, 0.01), model.size[2] / 2),
                T_world_shelf,
                rotation=_QUARTER_TURN if turned else None,
            )
        x += width + rng.uniform(*_PLAY)


@cache
def _kinds() -> list[list[ObjectModel]]:
    """Return the kinds of things that fit a shelf: bins twice, as they are the rule, containers, cartons."""
    height = SHELF_CLEARANCE - 0.03

    def fitting(names: list[str]) -> list[list[ObjectModel]]:
        models = [catalog_object(name) for name in names]
        return [[model] for model in models if min(model.size[:2]) <= 0.41 and model.size[2] <= height]

    bins = [[catalog_object(name)] for name in BINS]
    small = [name for name in (*TOTES, *SKUS) if max(catalog_object(name).size[:2]) <= 0.46]
    return [*bins, *bins, *fitting(small)]


_BETWEEN = 0.06
"""Free space between rows back to back (m)."""
_AISLE = 1.1
"""Width of the aisles between the rows behind (m)."""


@dataclass(frozen=True)
@ranged
class SmallPartsConfig(Layout):
    """Rows of shelves; what stands in them is fixed. It has no place for pallets: give it another side, or staging."""

    kind: ClassVar[str] = "small_parts"
    has_shelves: ClassVar[bool] = True

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
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and away from it (m)."""
        return self.bays * SHELF_SIZE[0], self._front(self.rows - 1) + SHELF_SIZE[1]

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
