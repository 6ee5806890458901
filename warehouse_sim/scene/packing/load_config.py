"""What a recipe says of unit loads."""

from dataclasses import dataclass, field, fields

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads import DRUMS, SACKS, SKUS, TOTES
from warehouse_sim.catalog.pallets.wear import WearConfig
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.packing.patterns import Pattern
from warehouse_sim.scene.packing.stacking import StackingConfig

_SHARES = (
    "empty_share",
    "worn_share",
    "tote_share",
    "drum_share",
    "sack_share",
    "mixed_share",
    "wrap_share",
    "slip_sheet_share",
    "corner_post_share",
)


@dataclass(frozen=True)
class WearRange:
    """How worn pallets are; each number is drawn for each pallet."""

    age: Distribution = field(default=Distribution.uniform(0.1, 1.0))
    """How weathered a pallet looks, 0-1."""
    missing: Distribution = field(default=Distribution.uniform(0.0, 0.5))
    """Share of the boards that can be missing and are, 0-1."""
    broken: Distribution = field(default=Distribution.uniform(0.0, 0.2))
    """Share of the deck and base boards that have lost an end, 0-1."""
    displaced: Distribution = field(default=Distribution.uniform(0.0, 0.5))
    """Share of the deck boards and skids that are out of place, 0-1."""
    twisted: Distribution = field(default=Distribution.uniform(0.0, 0.4))
    """Share of the blocks that are turned, 0-1."""
    stains: Distribution = field(default=Distribution.uniform(0.0, 0.5))
    """Share of the deck boards with stains, 0-1."""
    stamps: Distribution = field(default=Distribution.uniform(0.4, 1.0))
    """Share of the brands and stencils that can still be read, 0-1."""

    def __post_init__(self) -> None:
        for item in fields(self):
            limits = getattr(self, item.name)
            if limits.low < 0.0 or limits.high > 1.0:
                raise ValueError(f"{item.name} must stay within 0-1; give it min and max")

    def drawn(self, rng: np.random.Generator) -> WearConfig:
        """Return the wear of one pallet."""
        return WearConfig(**{item.name: getattr(self, item.name).draw(rng) for item in fields(self)})


@dataclass(frozen=True)
class UnitLoadConfig:
    """What a pallet carries."""

    empty_share: float = 0.25
    """Share of the pallets that carry nothing, 0-1."""
    pallets: tuple[str, ...] = ("epal1", "epal1_new", "epal1_grey")
    """Catalog names of the pallets to choose from; a name given twice is chosen twice as often."""
    worn_share: float = 0.0
    """Share of the pallets that are worn, 0-1."""
    wear: WearRange = field(default_factory=WearRange)
    """How worn those are."""
    cartons: tuple[str, ...] = tuple(SKUS)
    """Catalog names of the carton SKUs to choose from."""
    totes: tuple[str, ...] = tuple(TOTES)
    """Catalog names of the euro containers to choose from."""
    drums: tuple[str, ...] = tuple(DRUMS)
    """Catalog names of the drums to choose from."""
    sacks: tuple[str, ...] = tuple(SACKS)
    """Catalog names of the sacks to choose from."""
    tote_share: float = 0.0
    """Share of the loaded pallets that carry totes, 0-1; what tote, drum and sack share leave carries cartons."""
    drum_share: float = 0.0
    """Share of the loaded pallets that carry drums, 0-1."""
    sack_share: float = 0.0
    """Share of the loaded pallets that carry sacks, 0-1."""
    mixed_share: float = 0.0
    """Share of the carton loads that are picked orders of several SKUs, 0-1; the others hold one SKU."""
    patterns: tuple[Pattern, ...] = ("column",)
    """Patterns of cartons, totes and sacks; a size that allows none of them is stacked in columns."""
    height: Distribution = field(default=Distribution.uniform(0.3, 1.0))
    """Height of the load on a pallet (m), cut to whole layers, at least one; the beam above limits it too."""
    max_cartons: int = 24
    """Most pieces on one pallet, >= 1; whole layers are left out to keep it, but never the first."""
    overhang_mm: Distribution = field(default=Distribution.constant(0.0))
    """How far cells may stand out over each edge of the pallet (mm), -100 to 60; gaps and shifts come on top."""
    stacking: StackingConfig = field(default_factory=StackingConfig)
    """How carefully pieces are stacked."""
    wrap_share: float = 0.0
    """Share of the loads that are wrapped in stretch film, 0-1."""
    slip_sheet_share: float = 0.0
    """Share of the loads that stand on a sheet of board, 0-1."""
    corner_post_share: float = 0.0
    """Share of the loads of one carton SKU that have posts at their four corners, 0-1."""

    def __post_init__(self) -> None:
        for name in _SHARES:
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be 0-1, found {getattr(self, name)}")
        if self.tote_share + self.drum_share + self.sack_share > 1.0 + 1e-9:
            raise ValueError("tote_share, drum_share and sack_share must not exceed 1 together")
        if self.max_cartons < 1:
            raise ValueError(f"max_cartons must be >= 1, found {self.max_cartons}")
        if not self.patterns:
            raise ValueError("patterns must list at least one pattern")
        if self.overhang_mm.low < -100.0 or self.overhang_mm.high > 60.0:
            raise ValueError("overhang_mm must stay within -100 to 60; give it min and max")
        for setting in ("pallets", "cartons", "totes", "drums", "sacks"):
            self._require_class(setting, setting.removesuffix("s"))

    def _require_class(self, setting: str, class_name: str) -> None:
        names = getattr(self, setting)
        try:
            wrong = [name for name in names if catalog_object(name).class_name != class_name]
        except UnknownNameError as problem:
            raise ValueError(f"{setting}: {problem}") from problem
        if wrong or not names:
            raise ValueError(f"{setting} must list catalog objects of class {class_name}, found {wrong or 'none'}")
