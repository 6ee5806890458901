"""Which materials of which objects are one kind of surface, and what shares a look."""

from dataclasses import dataclass
from typing import Literal

from warehouse_sim.scene.appearance import palettes
from warehouse_sim.scene.appearance.palettes import Finish

Scope = Literal["scene", "load", "object"]
_STAGES = ("pallet_wood", "pallet_wood_new", "pallet_wood_grey", "pallet_wood_tan", "pallet_wood_dark")
_BLOCKS = ("pallet_block", "pallet_block_new", "pallet_block_grey")
_PLASTIC = ("plastic_grey", "plastic_black", "plastic_blue", "plastic_red", "plastic_white")
_DUSTY = ("plastic_grey_dusty", "plastic_black_dusty", "plastic_blue_dusty")


@dataclass(frozen=True)
class Surface:
    """One kind of surface."""

    materials: tuple[str, ...]
    """Materials of the catalog that it is made of."""
    scope: Scope
    """What looks alike: all of a scene, one article in one load, or one object."""
    palette: tuple[Finish, ...] = ()
    """Colours that are common for it; none where only shades of its own are."""
    classes: frozenset[str] | None = None
    """Classes of the objects that have it; None = all."""
    apart: bool = False
    """Whether each material varies by itself, as trousers do from vests; else all change in the same way."""
    looks: int = 1
    """Most looks in one scene."""


SURFACES: dict[str, Surface] = {
    "racks": Surface(("rack_blue",), "scene", palettes.RACKS),
    "beams": Surface(("rack_orange",), "scene", palettes.BEAMS),
    "guards": Surface(("guard_yellow",), "scene", palettes.GUARDS, frozenset({"guard", "bollard", "column"})),
    "structure": Surface(("steel_grey",), "scene", palettes.STRUCTURE),
    "walls": Surface(("wall_paint", "cladding"), "scene", palettes.WALLS),
    "roof": Surface(("roof_sheet",), "scene", palettes.WALLS),
    "doors": Surface(("door_white",), "scene", palettes.DOORS),
    "floors": Surface(("concrete", "epoxy_grey"), "scene", palettes.FLOORS, frozenset({"floor"})),
    "markings": Surface(("marking_yellow", "marking_white"), "scene", palettes.MARKINGS, apart=True),
    "trucks": Surface(("truck_orange", "truck_yellow", "truck_red"), "object", palettes.TRUCKS, looks=6),
    "clothes": Surface(
        ("hivis_yellow", "hivis_orange", "cloth_navy", "cloth_grey"), "object", palettes.CLOTHES, apart=True, looks=5
    ),
    "helmets": Surface(
        ("helmet_white", "helmet_yellow"), "object", palettes.HELMETS, frozenset({"person"}), looks=4
    ),
    "pallets": Surface((*_STAGES, *_BLOCKS), "object", classes=frozenset({"pallet"}), looks=12),
    "pallet_paint": Surface(
        ("pallet_blue", "pallet_blue_worn", *_PLASTIC, *_DUSTY),
        "object", palettes.PALLET_PAINT, frozenset({"pallet"}), looks=6,
    ),
    "boards": Surface(
        ("kraft", "kraft_light", "kraft_dark", "board_white"), "load", palettes.BOARDS,
        frozenset({"carton", "corner_post", "slip_sheet"}), looks=12,
    ),
    "prints": Surface(
        ("print_blue", "print_red", "print_green"), "load", palettes.PRINTS, frozenset({"carton", "sack"}),
        apart=True, looks=5,
    ),
    "tape": Surface(("tape",), "load", palettes.TAPE, looks=4),
    "sacks": Surface(("sack_paper", "sack_woven"), "load", palettes.SACKS, frozenset({"sack"}), looks=4),
    "totes": Surface(_PLASTIC, "load", palettes.TOTES, frozenset({"tote"}), apart=True, looks=4),
    "drums": Surface(
        ("steel_paint_blue", "steel_paint_black", *_PLASTIC), "load", palettes.DRUMS, frozenset({"drum"}), apart=True,
        looks=3,
    ),
    "clutter": Surface(
        ("steel_paint_blue", "steel_paint_black", *_PLASTIC), "object", palettes.TOTES, frozenset({"clutter"}),
        apart=True, looks=2,
    ),
    "film": Surface(("stretch_film", "stretch_film_thin", "stretch_film_dense"), "load", palettes.FILM, looks=3),
}  # fmt: skip
"""Setting of ``scene.appearance`` -> what it changes."""
