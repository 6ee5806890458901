"""A cantilever rack along the aisle, with pipes, sections, timber and panels on its arms."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.cantilever import (
    ARM_LENGTH,
    ARM_PITCH,
    CANTILEVERS,
    COLUMN,
    LONG_GOODS,
    arm_places,
    level_heights,
)
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Layout, Side
from warehouse_sim.schema import ObjectModel

_PITCH = 1.5
"""Distance from column to column (m)."""
_LAYERS = 2
"""Bundles on each other, at most."""
_AIR = 0.12
"""Least free height over goods (m)."""


@dataclass(frozen=True)
@ranged
class CantileverConfig(Layout):
    """Columns with arms; what lies on them is fixed. It has no place for pallets: give it another side, or staging."""

    kind: ClassVar[str] = "cantilever"

    fields: Annotated[int, Range(4, 24)] = 12
    """Fields of 1.5 m between columns, 4-24."""
    levels: Annotated[int, Range(3, 5)] = 4
    """Levels, the foot's included, 0.9 m apart, 3-5."""
    fill: Fraction = 0.85
    """Fraction of the places on the arms that are taken, 0-1."""
    sides: Literal["one", "both"] = "one"
    """Racks on one side of the aisle, with a wall behind, or on both."""

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle, and away from it (m)."""
        return self.fields * _PITCH + COLUMN[0], ARM_LENGTH + COLUMN[1]

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add columns, ties and goods; there are no places for pallets."""
        name = next(name for name, levels in CANTILEVERS.items() if levels == self.levels)
        size = catalog_object(name).size
        for index in range(self.fields + 1):
            draft.put(name, ((index - self.fields / 2) * _PITCH, self.depth / 2, size[2] / 2), T_world_side)
        for index in range(self.fields):
            for z in (0.6, size[2] - 0.2):
                draft.put(
                    "cantilever_brace",
                    ((index + 0.5 - self.fields / 2) * _PITCH, self.depth - COLUMN[1] / 2, z),
                    T_world_side,
                )
        for height in level_heights(self.levels):
            self._fill_level(draft, T_world_side, height, rng)
        return Side()

    def _fill_level(self, draft: SceneDraft, T_world_side: Transform, height: float, rng: np.random.Generator) -> None:
        """Lay goods of one kind after the other along a level, each on at least two arms."""
        start, end = -self.fields / 2 * _PITCH, self.fields / 2 * _PITCH
        while True:
            model = catalog_object(str(rng.choice(list(LONG_GOODS))))
            fields = _fields(model)
            if start + fields * _PITCH > end + 1e-6:
                fitting = [name for name in LONG_GOODS if start + _fields(catalog_object(name)) * _PITCH <= end + 1e-6]
                if not fitting:
                    return
                model = catalog_object(str(rng.choice(fitting)))
                fields = _fields(model)
            across = max(1, int((ARM_LENGTH + 0.04) / (model.size[1] + 0.04)))
            layers = max(1, min(_LAYERS, int((ARM_PITCH - _AIR - 0.1) / model.size[2])))
            for y in arm_places([float(model.size[1])] * across):
                for layer in range(int(rng.integers(1, layers + 1)) if rng.random() < self.fill else 0):
                    x = start + fields * _PITCH / 2 + rng.uniform(-0.05, 0.05)
                    draft.put(model.name, (x, y, height + (layer + 0.5) * model.size[2]), T_world_side)
            start += fields * _PITCH


def _fields(model: ObjectModel) -> int:
    """Return how many fields goods take up; in the middle of three they lie on two arms, whatever their length."""
    return max(3, int(model.size[0] / _PITCH) + 1)
