"""What a recipe says of unit loads."""

from dataclasses import dataclass, field, fields
from functools import cache
from typing import Annotated, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.drums import DRUMS
from warehouse_sim.catalog.loads.sacks import SACKS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.pallets.parametric import PalletKind, PalletShape, parametric_pallet
from warehouse_sim.catalog.pallets.wear.damaged import WearConfig
from warehouse_sim.catalog.shipped import CARRIERS
from warehouse_sim.errors import UnknownNameError, shown
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.packing.patterns import Pattern
from warehouse_sim.scene.packing.securing import FilmConfig
from warehouse_sim.scene.packing.stacking import StackingConfig
from warehouse_sim.schema import ObjectModel

FIRST_OBJ_ID, MOST = 600, 300
"""Numbers of their geometries: 600-899 are kept for them."""
_WOOD = ("pallet_wood", "pallet_wood_new", "pallet_wood_tan", "pallet_wood_grey", "pallet_wood_dark", "pallet_blue")
_PLASTIC = ("plastic_grey", "plastic_black", "plastic_blue", "plastic_red")
_MOULDED = ("runners", "feet")
_KINDS: tuple[PalletKind, ...] = ("skids", "perimeter", "stringers", "notched_stringers", "runners", "feet")
"""How sampled pallets are built, each as often."""


@dataclass(frozen=True)
@ranged
class SampledPalletsConfig:
    """How many pallets of free shape there are beside those of the catalog, and how their shapes are sampled."""

    count: Annotated[int, Range(0, MOST)] = 0
    """Different pallets, 0-300; each has its own obj_id, CAD surface and pockets in the dataset."""
    fraction: Fraction = 0.5
    """Fraction of the pallets in a scene that are these, 0-1; the others are those of ``loads.pallets``."""
    seed: Annotated[int, Range(0, 1_000_000)] = 0
    """Another seed, 0-1,000,000, draws other pallets; that of the dataset changes none: sets share their CAD."""
    length: Annotated[Distribution, Range(0.5, 2, "m")] = field(default=Distribution.uniform(0.95, 1.3))
    """Longer edge (m), 0.5-2; swapped with ``width`` where that comes out longer."""
    width: Annotated[Distribution, Range(0.4, 1.6, "m")] = field(default=Distribution.uniform(0.75, 1.15))
    """Shorter edge (m), 0.4-1.6."""
    opening: Annotated[Distribution, Range(0.06, 0.2, "m")] = field(default=Distribution.uniform(0.078, 0.112))
    """Clear height for forks (m), 0.06-0.2."""
    board: Annotated[Distribution, Range(0.01, 0.04, "m")] = field(default=Distribution.uniform(0.015, 0.026))
    """Thickness of boards and moulded decks (m), 0.01-0.04."""
    post: Annotated[Distribution, Range(0.02, 0.25, "m")] = field(default=Distribution.uniform(0.07, 0.15))
    """Width of the uprights at the ends of a face (m), 0.02-0.25."""
    middle_post: Annotated[Distribution, Range(0.02, 0.25, "m")] = field(default=Distribution.uniform(0.09, 0.16))
    """Width of the upright in the middle of a face (m), 0.02-0.25."""
    boards: Annotated[Distribution, Range(3, 15, whole=True)] = field(default=Distribution.uniform(5, 9))
    """Boards of a wooden deck, 3-15."""
    cover: Annotated[Distribution, Range(0.3, 0.95)] = field(default=Distribution.uniform(0.55, 0.9))
    """Fraction of a wooden deck that boards cover, 0.3-0.95."""


@cache
def sampled_pallets(config: SampledPalletsConfig) -> tuple[ObjectModel, ...]:
    """Return the pallets of ``config``, named after their number: "sampled_pallet_007"."""
    return tuple(_sampled(config, number) for number in range(config.count))


def _sampled(config: SampledPalletsConfig, number: int) -> ObjectModel:
    rng = np.random.default_rng([config.seed, number])
    kind: PalletKind = _KINDS[rng.integers(len(_KINDS))]
    width, length = sorted((config.length.sample(rng), config.width.sample(rng)))
    shape = PalletShape(
        kind=kind,
        length=_to_mm(length),
        width=_to_mm(width),
        opening=_to_mm(config.opening.sample(rng)),
        board=_to_mm(config.board.sample(rng)),
        post=_to_mm(config.post.sample(rng)),
        middle_post=_to_mm(config.middle_post.sample(rng)),
        boards=config.boards.sample_count(rng),
        cover=config.cover.sample(rng),
        lead=rng.uniform(1.0, 1.6),
        deck_along="x" if rng.random() < 0.5 else "y",
    )
    materials = _PLASTIC if kind in _MOULDED else _WOOD
    material = materials[rng.integers(len(materials))]
    return parametric_pallet(f"sampled_pallet_{number:03d}", FIRST_OBJ_ID + number, shape, material)


def _to_mm(length: float) -> float:
    """Return a length (m) in whole millimetres, as a saw is set."""
    return round(length, 3)


BULK_PALLETS = ("epal3", "epal2")
"""Pallets of 1,200 x 1,000 mm for carriers that fit none of the recipe's."""

_STAINS = Distribution.uniform(0.0, 0.5)
"""Fraction of a damaged pallet's deck boards with stains."""
_STAMPS = Distribution.uniform(0.4, 1.0)
"""Fraction of a damaged pallet's brands and stencils that can still be read."""


@dataclass(frozen=True)
@ranged
class WearRange:
    """How damaged pallets are; each number is sampled for each pallet."""

    age: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.1, 1.0))
    """How weathered a pallet looks, 0-1."""
    missing: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.0, 0.5))
    """Fraction of the boards that can be missing and are, 0-1."""
    broken: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.0, 0.2))
    """Fraction of the deck and base boards that have lost an end, 0-1."""
    displaced: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.0, 0.5))
    """Fraction of the deck boards and skids that are out of place, 0-1."""
    twisted: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.0, 0.4))
    """Fraction of the blocks that are turned, 0-1."""

    def sampled(self, rng: np.random.Generator) -> WearConfig:
        """Return the wear of one pallet."""
        drawn = {item.name: getattr(self, item.name).sample(rng) for item in fields(self)}
        return WearConfig(**drawn, stains=_STAINS.sample(rng), stamps=_STAMPS.sample(rng))


@dataclass(frozen=True)
@ranged
class UnitLoadConfig:
    """What a pallet carries."""

    empty_fraction: Fraction = 0.25
    """Fraction of the pallets that carry nothing, 0-1."""
    pallets: tuple[str, ...] = ("epal1", "epal1_new", "epal1_grey")
    """Names of the pallets to choose from, of the catalog or of ``sampled_pallets`` ("sampled_pallet_007"); a name
    given twice is chosen twice as often."""
    sampled_pallets: SampledPalletsConfig = field(default_factory=SampledPalletsConfig)
    """Pallets that are in no catalog, beside those."""
    damaged_fraction: Fraction = 0.0
    """Fraction of the pallets that are worn, 0-1."""
    wear: WearRange = field(default_factory=WearRange)
    """How worn those are."""
    cartons: tuple[str, ...] = tuple(SKUS)
    """Catalog names of the carton SKUs to choose from."""
    prints: Literal["fixed", "sampled"] = "fixed"
    """Whether all cartons of an SKU look alike, or have labels and prints drawn again in each scene."""
    totes: tuple[str, ...] = tuple(TOTES)
    """Catalog names of the euro containers to choose from."""
    drums: tuple[str, ...] = tuple(DRUMS)
    """Catalog names of the drums to choose from."""
    sacks: tuple[str, ...] = tuple(SACKS)
    """Catalog names of the sacks to choose from."""
    sack_shapes: bool = False
    """Whether sacks of one article differ in shape, or are all alike."""
    goods: tuple[str, ...] = ()
    """Articles of the user's own: files (.yaml, relative to the working directory) or catalog names of any class, see
    docs/custom_objects.md."""
    goods_fraction: Fraction = 0.0
    """Fraction of the loaded pallets that carry those, 0-1."""
    tote_fraction: Fraction = 0.0
    """Fraction of the loaded pallets that carry totes, 0-1; what these fractions leave carries cartons."""
    drum_fraction: Fraction = 0.0
    """Fraction of the loaded pallets that carry drums, 0-1."""
    sack_fraction: Fraction = 0.0
    """Fraction of the loaded pallets that carry sacks, 0-1."""
    carrier_fraction: Fraction = 0.0
    """Fraction of all loads that are carriers of their own: Gitterbox, roll container, octabin, big bag or IBC, 0-1."""
    carriers: tuple[str, ...] = tuple(CARRIERS)
    """Catalog names of the carriers to choose from; one that does not fit its place is left out there."""
    mixed_fraction: Fraction = 0.0
    """Fraction of the carton loads that are picked orders of several SKUs, 0-1; the others hold one SKU."""
    patterns: tuple[Pattern, ...] = ("column",)
    """Patterns of cartons, totes and sacks; a size that allows none of them is stacked in columns."""
    height: Annotated[Distribution, Range(0.05, 5, "m")] = field(default=Distribution.uniform(0.3, 1.0))
    """Height of the load on a pallet (m), cut to whole layers, at least one, 0.05-5; the beam above limits it too."""
    max_cartons: Annotated[int, Range(1, 1000)] = 24
    """Most pieces on one pallet, 1-1,000; whole layers are left out to keep it, but never the first."""
    stacking: StackingConfig = field(default_factory=StackingConfig)
    """How carefully pieces are stacked."""
    wrap_fraction: Fraction = 0.0
    """Fraction of the loads that are wrapped in stretch film, 0-1."""
    film: FilmConfig = field(default_factory=FilmConfig)
    """How film goes around them."""
    slip_sheet_fraction: Fraction = 0.0
    """Fraction of the loads that stand on a sheet of board, 0-1."""
    corner_post_fraction: Fraction = 0.0
    """Fraction of the loads of one carton SKU that have posts at their four corners, 0-1."""

    @property
    def pallet_names(self) -> tuple[str, ...]:
        """The pallets that loads may stand on: those of the recipe, and broad ones for bulk goods that fit no other."""
        return tuple(dict.fromkeys((*self.pallets, *(BULK_PALLETS if self.carrier_fraction > 0.0 else ()))))

    def __post_init__(self) -> None:
        if self.tote_fraction + self.drum_fraction + self.sack_fraction + self.goods_fraction > 1.0 + 1e-9:
            raise ValueError(
                "tote_fraction, drum_fraction, sack_fraction and goods_fraction must not exceed 1 together"
            )
        self._require_goods()
        if not self.patterns:
            raise ValueError("patterns must list at least one pattern")
        for setting in ("pallets", "cartons", "totes", "drums", "sacks"):
            self._require_class(setting, setting.removesuffix("s"))
        if unknown := [name for name in self.carriers if name not in CARRIERS]:
            raise ValueError(f"carriers must list some of {', '.join(CARRIERS)}, found {shown(unknown[0])}")

    def pallet(self, name: str) -> ObjectModel:
        """Return the pallet called ``name``, undamaged.

        Raises:
            UnknownNameError: Neither the catalog nor ``sampled_pallets`` has it.
        """
        sampled = {model.name: model for model in sampled_pallets(self.sampled_pallets)}
        return sampled[name] if name in sampled else catalog_object(name)

    def _require_goods(self) -> None:
        if self.goods_fraction > 0.0 and not self.goods:
            raise ValueError("goods_fraction needs articles; list them under goods")
        models = [catalog_object(name) for name in self.goods]
        if fixed := [model.name for model in models if model.mass <= 0.0 or not model.collision]:
            raise ValueError(f"goods must have a mass and a body to be stacked, which {fixed[0]} has not; set its mass")
        if len({model.obj_id for model in models}) < len({model.name for model in models}):
            raise ValueError("goods must differ in obj_id; number them from 1000 on")

    def _require_class(self, setting: str, class_name: str) -> None:
        names, find = getattr(self, setting), self.pallet if setting == "pallets" else catalog_object
        try:
            wrong = [name for name in names if find(name).class_name != class_name]
        except UnknownNameError as problem:
            raise ValueError(f"{setting}: {problem}") from problem
        if wrong or not names:
            raise ValueError(f"{setting} must list catalog objects of class {class_name}, found {wrong or 'none'}")
