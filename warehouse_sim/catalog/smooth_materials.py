"""The catalog's materials with smooth textures on floors, walls, board, plastic and coated steel.

Images of the frozen recipe, which numbers were measured on, are made of them.
"""

from dataclasses import replace

from warehouse_sim.catalog.materials import materials
from warehouse_sim.schema import Material

_SMOOTH = {
    **dict.fromkeys(("kraft", "kraft_light", "kraft_dark", "board_white"), ("kraft", 0.4)),
    **dict.fromkeys(("rack_blue", "rack_orange", "guard_yellow", "guard_black"), ("steel", 0.6)),
    **dict.fromkeys(("steel_grey", "steel_paint_blue", "steel_paint_black"), ("steel", 0.8)),
    **dict.fromkeys([f"plastic_{color}" for color in ("grey", "black", "blue", "red", "white")], ("plastic", 0.5)),
    "concrete": ("concrete", 3.0),
    "epoxy_grey": ("epoxy", 4.0),
    "blockwork": ("concrete", 1.2),
    "blockwork_dark": ("concrete", 1.2),
    "wall_paint": ("plastic", 3.0),
    "cladding": ("plastic", 2.0),
    "roof_sheet": ("plastic", 2.0),
    "door_white": ("plastic", 1.5),
    "gate_leaf": ("plastic", 1.5),
    "trailer_inside": ("plastic", 1.2),
    "panel_white": ("plastic", 2.2),
}
"""Material -> its texture and the edge of a tile (m)."""


def smooth_materials() -> dict[str, Material]:
    """Return every material of the catalog by name, smooth."""
    found = materials()
    for name, (texture, size) in _SMOOTH.items():
        found[name] = replace(found[name], texture=texture, texture_size=size)
    return found
