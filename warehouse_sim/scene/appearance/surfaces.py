"""Which materials of which objects are one kind of surface, what shares a look, and which colours are common for it.

Names and codes of paints are those of RAL Classic as its makers' charts approximate them in sRGB. Frames of racks are
mostly blue, grey or galvanised and beams orange, yellow or blue; guards are traffic yellow (RAL 1023) or orange;
sandwich panels come in the whites and greys of the coil coaters (RAL 9002, 9006, 9010, 7035). Weights are estimates.
"""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Finish:
    """One colour, and what else of a surface it brings."""

    code: str
    """Colour in sRGB, "#RRGGBB"."""
    weight: float = 1.0
    """How often, relative to the others of its palette."""
    bare: bool = False
    """Whether it is galvanised steel without paint."""
    opacity: float | None = None
    """Of a film; None keeps the material's."""


BLUE_5010, BLUE_5015, BLUE_5005 = "#004F7C", "#007CB0", "#005387"
ORANGE_2004, ORANGE_2003, ORANGE_2008 = "#E75B12", "#FA842B", "#ED6B21"
YELLOW_1023, YELLOW_1003, YELLOW_1021, YELLOW_1028 = "#F7B500", "#F9A800", "#F6B600", "#FF9C00"
RED_3000, RED_3020, RED_3002 = "#A72920", "#C1121C", "#9B2321"
GREEN_6005, GREEN_6029, GREEN_6024, GREEN_6018 = "#114232", "#006F3D", "#008351", "#57A639"
GREY_7035, GREY_7016, GREY_7042, GREY_7001 = "#C5C7C4", "#383E42", "#8E9291", "#8F999F"
WHITE_9010, WHITE_9002, WHITE_9003, SILVER_9006 = "#F1ECE1", "#D7D5CB", "#F4F8F4", "#A5A8A6"
BLACK_9005, BEIGE_1015, SAND_1001 = "#0E0E10", "#E6D2B5", "#D1BC8A"
_ZINC = "#BFC1C2"

RACKS = (
    Finish(BLUE_5010, 3.0), Finish(BLUE_5015, 2.0), Finish(BLUE_5005, 1.5), Finish(_ZINC, 3.0, bare=True),
    Finish(GREY_7035, 2.0), Finish(GREY_7016, 1.0), Finish(GREEN_6029), Finish(GREEN_6005), Finish(ORANGE_2004),
    Finish(YELLOW_1003, 0.7), Finish(RED_3000, 0.7), Finish(WHITE_9002, 0.7),
)  # fmt: skip
BEAMS = (
    Finish(ORANGE_2004, 2.0), Finish(ORANGE_2003), Finish(ORANGE_2008), Finish(YELLOW_1003, 2.5),
    Finish(YELLOW_1028, 1.0), Finish(BLUE_5015, 1.8), Finish(BLUE_5010), Finish(RED_3000, 1.2), Finish(RED_3020, 0.8),
    Finish(GREEN_6024, 1.6), Finish(GREY_7035, 1.2), Finish(_ZINC, 1.0, bare=True),
)  # fmt: skip
GUARDS = (
    Finish(YELLOW_1023, 5.0), Finish(YELLOW_1003, 3.0), Finish(ORANGE_2004, 2.0), Finish(RED_3020),
    Finish(BLUE_5010, 0.7),
)  # fmt: skip
STRUCTURE = (
    Finish(GREY_7035, 2.0), Finish(GREY_7042, 2.0), Finish(GREY_7016, 2.0), Finish(WHITE_9002, 2.0),
    Finish(BLUE_5010), Finish(GREEN_6005), Finish(RED_3000), Finish(_ZINC, 1.5, bare=True),
)  # fmt: skip
WALLS = (
    Finish(WHITE_9010, 3.0), Finish(WHITE_9002, 4.0), Finish(WHITE_9003, 2.0), Finish(SILVER_9006, 2.0),
    Finish(GREY_7035, 3.0), Finish(GREY_7042), Finish(BEIGE_1015, 1.5), Finish("#DDE3E2", 1.0),
    Finish("#B9CAD2", 0.7), Finish("#C9D2BF", 0.6), Finish("#B09A86", 0.25),
)  # fmt: skip
DOORS = (
    Finish(WHITE_9010, 3.0), Finish(SILVER_9006, 2.0), Finish(GREY_7016, 2.0), Finish(BLUE_5010, 2.0),
    Finish(RED_3000), Finish(GREEN_6005), Finish(ORANGE_2004, 0.7), Finish(BLUE_5015),
)  # fmt: skip
FLOORS = (
    Finish("#8B8A85", 3.0), Finish("#A09E98", 3.0), Finish("#74736F", 2.0), Finish("#918877", 2.0),
    Finish("#6E7C74", 1.0), Finish("#7E4F42", 0.5), Finish("#586B7C", 0.7), Finish("#B3B0A8", 1.5),
)  # fmt: skip
MARKINGS = (
    Finish(YELLOW_1023, 4.0), Finish(WHITE_9003, 3.0), Finish(RED_3020), Finish(BLUE_5015), Finish(GREEN_6024),
    Finish(ORANGE_2003),
)  # fmt: skip
TRUCKS = (
    Finish(ORANGE_2004, 2.0), Finish(YELLOW_1003, 2.0), Finish(YELLOW_1028), Finish(RED_3020, 2.0), Finish(RED_3002),
    Finish(GREEN_6018, 1.0), Finish(BLUE_5015, 1.5), Finish(GREY_7042), Finish(WHITE_9003, 0.7),
    Finish("#3B6EA5", 0.7),
)  # fmt: skip
CLOTHES = (
    Finish("#D7F205", 3.0), Finish("#F2581B", 2.5), Finish("#1F2A44", 2.0), Finish("#50555A", 1.5),
    Finish("#151618", 1.5), Finish("#7A1E25"), Finish("#2E4A36"), Finish("#3F6C9B"), Finish("#C2B280", 0.7),
    Finish("#E7E7E5", 0.5),
)  # fmt: skip
HELMETS = (
    Finish("#F4F4F2", 3.0), Finish("#F3C300", 2.5), Finish("#E2571E"), Finish("#1C4E9C", 1.5), Finish("#C01722"),
    Finish("#1E7B3E"), Finish("#2B2D30", 0.5),
)  # fmt: skip
PALLET_PAINT = (
    Finish("#0C4DA2", 3.0), Finish("#B4141E", 2.0), Finish("#20221F", 2.0), Finish("#4C4F52", 2.0), Finish("#1C6B3A"),
    Finish("#6D4B2F", 1.0), Finish("#1E6FB5", 1.0),
)  # fmt: skip
BOARDS = (
    Finish("#AD8C68", 4.0), Finish("#B99D7C", 4.0), Finish("#A07F5B", 3.0), Finish("#C5AB8A", 2.0),
    Finish("#8E6B48", 1.5), Finish("#E9E6DF", 3.0), Finish("#DCD3C0", 1.0), Finish("#1D4E89", 0.2),
    Finish("#B3232A", 0.18), Finish("#E3A51A", 0.12), Finish("#2F7D4F", 0.2), Finish("#2A2A2C", 0.2),
    Finish("#6C3F7F", 0.1), Finish("#C9567F", 0.08), Finish("#3FA6A0", 0.12),
)  # fmt: skip
"""One in twenty is of a full colour: shipping cartons are printed on brown or white board."""
PRINTS = (
    Finish("#1B3F8B", 2.0), Finish("#B5121B", 2.0), Finish("#0F7A3D", 1.5), Finish("#26272B", 3.0), Finish("#E07A10"),
    Finish("#6A2C91", 0.7), Finish("#0093B2"), Finish("#C6168D", 0.5), Finish("#7A4A1E"),
)  # fmt: skip
TAPE = (
    Finish("#B98A52", 3.0), Finish("#D9C7A6", 3.0), Finish("#EFEDE8", 1.5), Finish("#C62328", 0.7),
    Finish("#8A6236", 1.5), Finish("#F0C419", 0.3), Finish("#2A63B0", 0.3),
)  # fmt: skip
SACKS = (
    Finish("#B8946A", 3.0), Finish("#EDEBE4", 4.0), Finish("#D9CDB4", 2.0), Finish("#E7C34B", 0.7),
    Finish("#8FB7D6", 0.7), Finish("#5E8F54", 0.7), Finish("#3A3A3C", 0.5), Finish("#C96B4A", 0.5),
)  # fmt: skip
TOTES = (
    Finish("#1F4E99", 3.0), Finish("#B5202A", 2.5), Finish("#6B7074", 3.0), Finish("#1E7A46", 2.0),
    Finish("#E2A90B", 1.5), Finish("#2C2E31", 1.5), Finish("#E4E6E6"), Finish("#D9651B"), Finish("#5B2A7A", 0.3),
    Finish("#27A0A8", 0.3),
)  # fmt: skip
DRUMS = (
    Finish("#123C7C", 4.0), Finish("#191A1C", 2.0), Finish("#B3181F", 1.5), Finish("#E9E8E2", 1.5), Finish("#0F6A3C"),
    Finish("#E3A008"), Finish("#8C9196", 1.0), Finish("#D35A12", 0.7),
)  # fmt: skip
FILM = (
    Finish("#E7E9EB", 8.0), Finish("#DDE7F2", 1.0), Finish("#0F1012", 0.6, opacity=0.85),
    Finish("#1E4FA3", 0.4, opacity=0.55), Finish("#EDEDED", 0.6, opacity=0.75), Finish("#3E8F57", 0.3, opacity=0.5),
)  # fmt: skip

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
    "racks": Surface(("rack_blue",), "scene", RACKS),
    "beams": Surface(("rack_orange",), "scene", BEAMS),
    "guards": Surface(("guard_yellow",), "scene", GUARDS, frozenset({"guard", "bollard", "column"})),
    "structure": Surface(("steel_grey",), "scene", STRUCTURE),
    "walls": Surface(("wall_paint", "cladding"), "scene", WALLS),
    "roof": Surface(("roof_sheet",), "scene", WALLS),
    "doors": Surface(("door_white",), "scene", DOORS),
    "floors": Surface(("concrete", "epoxy_grey"), "scene", FLOORS, frozenset({"floor"})),
    "markings": Surface(("marking_yellow", "marking_white"), "scene", MARKINGS, apart=True),
    "trucks": Surface(("truck_orange", "truck_yellow", "truck_red"), "object", TRUCKS, looks=6),
    "clothes": Surface(
        ("hivis_yellow", "hivis_orange", "cloth_navy", "cloth_grey"), "object", CLOTHES, apart=True, looks=5
    ),
    "helmets": Surface(
        ("helmet_white", "helmet_yellow"), "object", HELMETS, frozenset({"person"}), looks=4
    ),
    "pallets": Surface((*_STAGES, *_BLOCKS), "object", classes=frozenset({"pallet"}), looks=12),
    "pallet_paint": Surface(
        ("pallet_blue", "pallet_blue_worn", *_PLASTIC, *_DUSTY),
        "object", PALLET_PAINT, frozenset({"pallet"}), looks=6,
    ),
    "boards": Surface(
        ("kraft", "kraft_light", "kraft_dark", "board_white"), "load", BOARDS,
        frozenset({"carton", "corner_post", "slip_sheet"}), looks=12,
    ),
    "prints": Surface(
        ("print_blue", "print_red", "print_green"), "load", PRINTS, frozenset({"carton", "sack"}),
        apart=True, looks=5,
    ),
    "tape": Surface(("tape",), "load", TAPE, looks=4),
    "sacks": Surface(("sack_paper", "sack_woven"), "load", SACKS, frozenset({"sack"}), looks=4),
    "totes": Surface(_PLASTIC, "load", TOTES, frozenset({"tote"}), apart=True, looks=4),
    "drums": Surface(
        ("steel_paint_blue", "steel_paint_black", *_PLASTIC), "load", DRUMS, frozenset({"drum"}), apart=True,
        looks=3,
    ),
    "clutter": Surface(
        ("steel_paint_blue", "steel_paint_black", *_PLASTIC), "object", TOTES, frozenset({"clutter"}),
        apart=True, looks=2,
    ),
    "film": Surface(("stretch_film", "stretch_film_thin", "stretch_film_dense"), "load", FILM, looks=3),
}  # fmt: skip
"""Setting of ``scene.appearance`` -> what it changes."""
