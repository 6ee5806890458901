"""A unit load in its own frame: a pallet and the cartons on it, before it has a place."""

from dataclasses import dataclass, field

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.cartons import SKUS
from warehouse_sim.catalog.pallets import HEIGHT, LENGTH, WIDTH
from warehouse_sim.errors import PlacementError, UnknownNameError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.column_pattern import StackingConfig, column_cells, stack_cartons
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import SceneDraft

INITIAL_AIR = 0.0005
"""Gap under a pallet before settling (m)."""
_HEADROOM_LEFT = 0.01
"""Least air over a load (m)."""


@dataclass(frozen=True)
class UnitLoadConfig:
    """What a pallet carries."""

    empty_share: float = 0.25
    """Share of the pallets that carry nothing, 0-1."""
    pallets: tuple[str, ...] = ("epal1", "epal1_new", "epal1_grey")
    """Catalog names of the pallets to choose from; a name given twice is chosen twice as often."""
    cartons: tuple[str, ...] = tuple(SKUS)
    """Catalog names of the carton SKUs to choose from, one a load."""
    height: Distribution = field(default=Distribution.uniform(0.3, 1.0))
    """Height of the cartons on a pallet (m), cut to whole layers, at least one; the beam above limits it too."""
    max_cartons: int = 24
    """Most cartons on one pallet, >= 1; whole layers are left out to keep it, but never the first."""
    stacking: StackingConfig = field(default_factory=StackingConfig)
    """How carefully cartons are stacked."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.empty_share <= 1.0:
            raise ValueError(f"empty_share must be 0-1, found {self.empty_share}")
        if self.max_cartons < 1:
            raise ValueError(f"max_cartons must be >= 1, found {self.max_cartons}")
        for setting, class_name in (("pallets", "pallet"), ("cartons", "carton")):
            names = getattr(self, setting)
            try:
                wrong = [name for name in names if catalog_object(name).class_name != class_name]
            except UnknownNameError as problem:
                raise ValueError(f"{setting}: {problem}") from problem
            if wrong or not names:
                raise ValueError(f"{setting} must list catalog objects of class {class_name}, found {wrong or 'none'}")


@dataclass(frozen=True, eq=False)
class UnitLoad:
    """Models and their poses in the load's frame: on the support under the pallet's centre, x along 1.2 m, z up."""

    pieces: tuple[tuple[str, Transform], ...]

    def envelope(self) -> OrientedBox:
        """Return the box around all pieces in the load's frame, from 20 mm up so that the support itself is free."""
        stack = BoxStack.of(
            [OrientedBox(T_load_piece, catalog_object(name).size) for name, T_load_piece in self.pieces]
        )
        lows, highs = stack.extents()
        low, high = np.maximum(lows.min(axis=0), [-np.inf, -np.inf, 0.02]), highs.max(axis=0)
        return OrientedBox(make_transform(translation=(low + high) / 2), high - low)

    def add_to(self, draft: SceneDraft, T_world_load: Transform) -> None:
        """Add the pieces to ``draft`` as one new group."""
        group = draft.new_group()
        for name, T_load_piece in self.pieces:
            draft.add(name, T_world_load @ T_load_piece, group)


def make_unit_load(headroom: float, config: UnitLoadConfig, rng: np.random.Generator) -> UnitLoad:
    """Draw a unit load that is at most ``headroom`` (m) high, pallet included.

    Raises:
        PlacementError: No carton of the recipe is low enough, or cartons cannot be jittered as asked.
    """
    pallet = str(rng.choice(config.pallets))
    pieces = [(pallet, make_transform(translation=np.array([0.0, 0.0, HEIGHT / 2 + INITIAL_AIR])))]
    if rng.random() >= config.empty_share:
        sku, layers = _choose_cartons(headroom - HEIGHT - _HEADROOM_LEFT, config, rng)
        T_load_deck = make_transform(translation=np.array([0.0, 0.0, HEIGHT + INITIAL_AIR]))
        poses = stack_cartons(catalog_object(sku).size, layers, (LENGTH, WIDTH), config.stacking, rng)
        pieces += [(sku, T_load_deck @ T_deck_carton) for T_deck_carton in poses]
    return UnitLoad(tuple(pieces))


def _choose_cartons(free: float, config: UnitLoadConfig, rng: np.random.Generator) -> tuple[str, int]:
    """Draw the SKU and the number of layers for a load with ``free`` metres above the pallet."""
    low_enough = [name for name in config.cartons if catalog_object(name).size[2] <= free]
    if not low_enough:
        raise PlacementError(
            f"no carton of the recipe fits the {free:.2f} m above a pallet; raise beam_levels or list lower cartons"
        )
    sku = str(rng.choice(low_enough))
    size = catalog_object(sku).size
    wanted = min(config.height.draw(rng), free)
    per_layer = len(column_cells(size, (LENGTH, WIDTH), 0.0)[0])
    return sku, max(1, min(int(wanted / size[2]), config.max_cartons // per_layer))
