"""Pallets that are in no catalog, drawn once for a recipe: the same in every scene and under every seed."""

from dataclasses import dataclass, field
from functools import cache
from typing import Annotated

import numpy as np

from warehouse_sim.catalog.pallets.parametric import PalletKind, PalletShape, parametric_pallet
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.schema import ObjectModel

FIRST_OBJ_ID, MOST = 600, 300
"""Numbers of their geometries: 600-899 are kept for them."""
_WOOD = ("pallet_wood", "pallet_wood_new", "pallet_wood_tan", "pallet_wood_grey", "pallet_wood_dark", "pallet_blue")
_PLASTIC = ("plastic_grey", "plastic_black", "plastic_blue", "plastic_red")
_MOULDED = ("runners", "feet")


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
    kinds: tuple[PalletKind, ...] = ("skids", "perimeter", "stringers", "notched_stringers", "runners", "feet")
    """How they are built; a kind given twice is sampled twice as often."""
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

    def __post_init__(self) -> None:
        if not self.kinds:
            raise ValueError("kinds must list at least one way to build a pallet")


@cache
def sampled_pallets(config: SampledPalletsConfig) -> tuple[ObjectModel, ...]:
    """Return the pallets of ``config``, named after their number: "sampled_pallet_007"."""
    return tuple(_sampled(config, number) for number in range(config.count))


def _sampled(config: SampledPalletsConfig, number: int) -> ObjectModel:
    rng = np.random.default_rng([config.seed, number])
    kind: PalletKind = config.kinds[rng.integers(len(config.kinds))]
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
