"""Textures of the materials, baked from fixed seeds: factors on albedo and roughness, and normals.

Rows are v, columns are u; each texture tiles without seams.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from warehouse_sim.catalog.textures.fresh import (
    STRETCH,
    brushed,
    concrete,
    epoxy,
    film,
    galvanised,
    kraft,
    plastic,
    rubber,
    steel,
    wood,
)
from warehouse_sim.catalog.textures.tile import TextureSet, Tile, quantised
from warehouse_sim.catalog.textures.used import blockwork, coat, enamel, liner, precast, slab
from warehouse_sim.catalog.textures.worn import (
    concrete_worn,
    epoxy_worn,
    kraft_worn,
    plastic_worn,
    steel_worn,
    wood_worn,
)

TEXTURES: dict[str, Callable[[np.random.Generator], Tile]] = {
    painter.__name__: painter
    for painter in (
        *(wood, kraft, concrete, steel, plastic, epoxy, film, rubber, brushed, galvanised),
        *(concrete_worn, epoxy_worn, steel_worn, wood_worn, kraft_worn, plastic_worn),
        *(slab, coat, precast, blockwork, liner, enamel),
    )
}
"""Name, as in ``Material.texture`` -> the function that paints it. A new one goes to the end: the place is the seed."""


@cache
def paint(name: str) -> TextureSet:
    """Return the texture called ``name``."""
    return quantised(TEXTURES[name](np.random.default_rng([2026, list(TEXTURES).index(name)])))


def stretch(name: str) -> int:
    """Return how many times as long along u as along v a tile of the texture called ``name`` is laid out."""
    return STRETCH if name in ("wood", "wood_worn", "film") else 1
