"""Textures of the materials, baked from fixed seeds: factors on albedo and roughness, and normals.

Rows are v, columns are u; each texture tiles without seams.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from warehouse_sim.catalog.textures.detail import (
    DETAIL_STRETCH,
    Detail,
    detail_board,
    detail_coating,
    detail_concrete,
    detail_plaster,
    detail_wood,
    detail_wood_end,
    detail_zinc,
)
from warehouse_sim.catalog.textures.fresh import STRETCH as WOOD_STRETCH
from warehouse_sim.catalog.textures.fresh import (
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
DETAILS: dict[str, Callable[[np.random.Generator], Tile]] = {
    painter.__name__: painter
    for painter in (
        *(detail_concrete, detail_plaster, detail_board, detail_wood, detail_wood_end, detail_coating, detail_zinc),
    )
}
"""Name, as in ``Detail.name`` -> the function that paints it. A new one goes to the end: the place is the seed."""
_DETAIL_SEED = 0xDE7A
_ON_WOOD = Detail("detail_wood", 0.25, "detail_wood_end")
_ON_BOARD = Detail("detail_board", 0.25)
DETAIL_OF = {
    **dict.fromkeys(("slab", "concrete_worn"), Detail("detail_concrete", 0.8)),
    **dict.fromkeys(("precast", "blockwork"), Detail("detail_plaster", 1.2)),
    **dict.fromkeys(("concrete", "coat", "epoxy", "epoxy_worn"), Detail("detail_plaster", 0.6)),
    **dict.fromkeys(("wood", "wood_worn"), _ON_WOOD),
    **dict.fromkeys(("liner", "kraft", "kraft_worn"), _ON_BOARD),
    **dict.fromkeys(("enamel", "steel", "steel_worn"), Detail("detail_coating", 0.2)),
    **dict.fromkeys(("plastic", "plastic_worn", "rubber"), Detail("detail_coating", 0.25)),
    **dict.fromkeys(("galvanised", "brushed"), Detail("detail_zinc", 0.2)),
}
"""Texture -> what lies over it where an image shows it from near."""


@cache
def paint(name: str) -> TextureSet:
    """Return the texture or detail called ``name``."""
    if name in DETAILS:
        return quantised(DETAILS[name](np.random.default_rng([2026, _DETAIL_SEED, list(DETAILS).index(name)])))
    return quantised(TEXTURES[name](np.random.default_rng([2026, list(TEXTURES).index(name)])))


def stretch(name: str) -> int:
    """Return how many times as long along u as along v a tile of the texture called ``name`` is laid out."""
    if name == "detail_wood":
        return DETAIL_STRETCH
    return WOOD_STRETCH if name in ("wood", "wood_worn", "film") else 1
