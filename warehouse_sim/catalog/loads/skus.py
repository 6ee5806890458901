"""The finite list of carton SKUs, so that sizes are exact and BOP models few.

Footprints are the modules of ISO 3394:2012 (600 x 400, 600 x 500 and 550 x 366 mm) and submultiples of the first, or
free sizes as products have them. Filled consumer cartons weigh 80-250 kg for each cubic metre of outer volume; one that
is lifted by hand stays under 25 kg (EN 1005-2). Cans, bottles, tiles, paper and parts weigh 280-500 kg a cubic metre
and come in double wall board; the larger ones of these are lifted by machine.
"""

from dataclasses import dataclass, replace
from typing import Literal

from warehouse_sim.catalog.loads.artwork import Mark


@dataclass(frozen=True)
class Artwork:
    """What is printed on a carton."""

    brand: str
    """Word on the long sides."""
    ink: str
    """Material of the print."""
    marks: tuple[Mark, ...] = ("up",)
    """Handling marks on all four sides."""
    band: str | None = None
    """Material of a coloured band below the lid, on which the brand stands in white; None for plain board."""
    hand_holes: bool = False
    """Whether the short sides have holes to grip."""
    straps: bool = False
    """Whether two bands of plastic go around the carton."""


@dataclass(frozen=True)
class CartonSku:
    """One stock-keeping unit."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float
    """Outer edge along x (m)."""
    width: float
    """Outer edge along y (m)."""
    height: float
    """Outer edge along z (m)."""
    density: float
    """Mass over outer volume (kg/m^3)."""
    board: str
    """Material of the body."""
    label: tuple[float, float]
    """Width and height (m) of the label."""
    label_material: str = "label_paper"
    """Material of the label."""
    artwork: Artwork | None = None
    """Print, marks and barcode; None for a carton with a plain band as label."""
    walls: Literal[1, 2] = 1
    """Fluted layers of the board."""

    @property
    def name(self) -> str:
        """The catalog name, from the size in millimetres."""
        return "carton_" + "x".join(str(round(1000 * edge)) for edge in (self.length, self.width, self.height))


_A7, _A6, _A5 = (0.105, 0.074), (0.148, 0.105), (0.21, 0.148)
_FRAGILE: tuple[Mark, ...] = ("up", "fragile")
_FULL = Artwork("ALTO", "print_dark", ("up", "fragile", "dry"), hand_holes=True)

SKUS = {
    sku.name: sku
    for sku in (
        CartonSku(11, 0.6, 0.4, 0.40, 120.0, "kraft", (0.148, 0.105)),
        CartonSku(12, 0.6, 0.4, 0.30, 150.0, "kraft_light", (0.30, 0.12), "print_blue"),
        CartonSku(13, 0.6, 0.4, 0.22, 180.0, "kraft_dark", (0.148, 0.105)),
        CartonSku(14, 0.4, 0.3, 0.30, 160.0, "kraft", (0.20, 0.14), "print_dark"),
        CartonSku(15, 0.4, 0.3, 0.20, 200.0, "board_white", (0.26, 0.08), "print_red"),
        CartonSku(16, 0.3, 0.2, 0.20, 220.0, "kraft_light", (0.105, 0.074)),
        CartonSku(17, 0.6, 0.4, 0.35, 130.0, "kraft", _A5, artwork=_FULL),
        CartonSku(18, 0.6, 0.4, 0.25, 170.0, "board_white", _A6,
                  artwork=Artwork("HELIOS", "print_blue", band="print_blue")),
        CartonSku(19, 0.4, 0.3, 0.25, 170.0, "kraft_light", _A6, artwork=Artwork("PILOT", "print_red", ("up", "dry"))),
        CartonSku(20, 0.4, 0.3, 0.15, 210.0, "kraft", _A7, artwork=Artwork("OPAL", "print_dark", ("up", "fragile"))),
        CartonSku(21, 0.3, 0.2, 0.15, 230.0, "kraft_dark", _A7, artwork=Artwork("TEAL", "print_blue")),
        CartonSku(22, 0.6, 0.2, 0.24, 190.0, "kraft", _A6,
                  artwork=Artwork("COLT", "print_dark", ("up", "dry"), straps=True)),
        CartonSku(23, 0.6, 0.5, 0.30, 120.0, "kraft_light", _A5,
                  artwork=replace(_FULL, brand="ATLAS", ink="print_blue")),
        CartonSku(24, 0.55, 0.366, 0.28, 150.0, "board_white", _A6,
                  artwork=Artwork("TULIP", "print_red", band="print_red")),
        CartonSku(25, 0.385, 0.285, 0.24, 160.0, "kraft_dark", _A6,
                  artwork=Artwork("SALTO", "print_dark", ("up", "dry"))),
        CartonSku(26, 0.43, 0.33, 0.31, 140.0, "kraft", _A6,
                  artwork=Artwork("NAUTIC", "print_blue", _FRAGILE, straps=True)),
        CartonSku(27, 0.35, 0.35, 0.33, 130.0, "kraft_light", _A6, artwork=Artwork("COSI", "print_red", _FRAGILE)),
        CartonSku(28, 0.59, 0.39, 0.18, 160.0, "board_white", _A6,
                  artwork=Artwork("PLANET", "print_green", ("up", "dry"))),
    )
}  # fmt: skip
"""Catalog name -> SKU."""

_HANDLED: tuple[Mark, ...] = ("up", "dry")
HEAVY_SKUS = {
    sku.name: sku
    for sku in (
        CartonSku(371, 0.6, 0.4, 0.32, 310.0, "kraft", _A5, walls=2,
                  artwork=Artwork("CANTIL", "print_dark", _HANDLED, straps=True)),
        CartonSku(372, 0.6, 0.4, 0.21, 460.0, "kraft_light", _A6, walls=2,
                  artwork=Artwork("SOLPAN", "print_blue", ("dry",))),
        CartonSku(373, 0.4, 0.4, 0.38, 380.0, "kraft", _A6, walls=2, artwork=Artwork("HASTO", "print_red", _HANDLED)),
        CartonSku(374, 0.8, 0.6, 0.42, 285.0, "kraft_dark", _A5, walls=2,
                  artwork=Artwork("PLATEN", "print_dark", _HANDLED, straps=True)),
        CartonSku(375, 0.8, 0.6, 0.32, 350.0, "kraft", _A5, walls=2,
                  artwork=Artwork("CUTONE", "print_dark", _HANDLED)),
        CartonSku(376, 0.8, 0.4, 0.36, 320.0, "board_white", _A5, walls=2,
                  artwork=Artwork("NEPTUS", "print_green", _HANDLED, band="print_green")),
    )
}  # fmt: skip
"""Catalog name -> SKU of dense goods, which recipes list themselves."""
ALL_SKUS = SKUS | HEAVY_SKUS
"""Catalog name -> SKU of every carton."""
