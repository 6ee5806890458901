"""Damaged pallets: other boards and look; frame, pockets, size, symmetry and collision stay."""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog.pallets.wear.brands import branded
from warehouse_sim.catalog.pallets.wear.damage import (
    members_of,
    with_broken,
    with_displaced,
    with_twisted,
    without_missing,
)
from warehouse_sim.catalog.pallets.wear.surface import aged, nailed, stained
from warehouse_sim.ranges import Fraction, check_ranges
from warehouse_sim.schema import ObjectModel, Part
from warehouse_sim.schema.things import SAME_SHAPE


@dataclass(frozen=True)
class WearConfig:
    """How much a pallet has been through; boards, blocks and marks are what wooden pallets have."""

    age: Fraction = 0.0
    """How weathered it looks, 0-1: 0 keeps its materials, 1 makes it grey and dark, or dusty if it is plastic."""
    missing: Fraction = 0.0
    """Fraction of the boards that can be missing and are, 0-1: inner deck boards whose gap no carton falls into."""
    broken: Fraction = 0.0
    """Fraction of the deck and base boards that have lost an end, 0-1."""
    displaced: Fraction = 0.0
    """Fraction of the deck boards and skids that are out of place by up to 10 mm, 0-1."""
    twisted: Fraction = 0.0
    """Fraction of the blocks that are turned, their corners by up to 10 mm, 0-1."""
    stains: Fraction = 0.0
    """Fraction of the deck boards with stains, 0-1."""
    stamps: Fraction = 1.0
    """Fraction of the brands and stencils that can still be read, 0-1."""

    def __post_init__(self) -> None:
        check_ranges(self)


def damaged(model: ObjectModel, wear: WearConfig, rng: np.random.Generator) -> ObjectModel:
    """Return ``model`` after use, called ``<name>~<tag>``, or ``<name>~look-<tag>`` where it has only aged.

    Its meaning is that of ``model``.

    The collision boxes stay, too: where a deck board is gone or broken, physics still sees the whole deck, and what is
    missing is never so much that a carton would stand on nothing.

    Args:
        model: A pallet of the catalog.
        wear: What happened to it.
        rng: Stream to draw from; two draws give two pallets.
    """
    members = aged(without_missing(members_of(model), wear.missing, rng), wear.age, rng)
    members = stained(nailed(with_broken(members, wear.broken, rng)), wear.stains, rng)
    members = branded(members, model, wear.stamps, rng)
    members = with_twisted(with_displaced(members, wear.displaced, rng), wear.twisted, rng)
    parts = tuple(part for member in members for part in member.parts)
    tag = f"{rng.integers(1 << 32):08x}"
    return replace(model, name=f"{model.name}~{SAME_SHAPE * _same_shape(model.parts, parts)}{tag}", parts=parts)


def _same_shape(built: tuple[Part, ...], used: tuple[Part, ...]) -> bool:
    """Return whether parts differ in their materials alone, as those of moulded pallets do."""
    return len(built) == len(used) and all(
        a.mesh is b.mesh and np.array_equal(a.T_object_part, b.T_object_part) and np.array_equal(a.scale, b.scale)
        for a, b in zip(built, used, strict=True)
    )
