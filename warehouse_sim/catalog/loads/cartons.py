"""Cartons: the finite list of SKUs, so that sizes are exact and BOP models few; board, closing tape, print and labels.

Footprints are the modules of ISO 3394:2012 (600 x 400, 600 x 500 and 550 x 366 mm) and submultiples of the first, or
free sizes as products have them. Filled consumer cartons weigh 80-250 kg for each cubic metre of outer volume; one that
is lifted by hand stays under 25 kg (EN 1005-2). Cans, bottles, tiles, paper and parts weigh 280-500 kg a cubic metre
and come in double wall board; the larger ones of these are lifted by machine.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from warehouse_sim.catalog.loads.artwork import (
    Mark,
    Shapes,
    Side,
    barcode,
    handling_mark,
    moved,
    on_side,
    rectangle,
    text_lines,
    word,
    word_width,
)
from warehouse_sim.catalog.parts import box_part, fused, model_of
from warehouse_sim.geometry.pose import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part


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


TAPE_WIDTH, TAPE_DROP = 0.05, 0.07
"""Width of the closing tape and how far it reaches down the two ends (m)."""
SKIN = 0.0005
"""How far tape and labels stand proud of the board (m); the outer size includes it."""
PRINT_SKIN = 0.001
"""The same for printed cartons, whose ink lies on the paper of the label (m)."""
STRAP_WIDTH = 0.012
_INK = 0.9 * PRINT_SKIN
"""Thickness of print that reaches down to the board (m)."""
_LONG_SIDES: tuple[Side, ...] = ("-y", "+y")
_SHORT_SIDES: tuple[Side, ...] = ("-x", "+x")
_LABELLED: tuple[Side, ...] = ("+y", "+x")
_MARGIN = 0.025
"""Distance of print and labels from the edges of a side (m); labels keep at least 19 mm (GS1)."""


def carton(sku: str) -> ObjectModel:
    """Build the carton called ``sku`` ("carton_600x400x300")."""
    item = ALL_SKUS[sku]
    size = (item.length, item.width, item.height)
    return model_of(
        sku,
        "carton",
        item.obj_id,
        size,
        _plain_parts(item) if item.artwork is None else _printed_parts(item, item.artwork),
        mass=item.density * item.length * item.width * item.height,
        symmetry=SymmetryGroup.turns("z", 2) if item.artwork is None else SymmetryGroup.trivial(),
    )


def _plain_parts(item: CartonSku) -> tuple[Part, ...]:
    """Return three boxes: the body, the tape that closes it along x, and a band that shows on both long sides."""
    length, width, height = item.length, item.width, item.height
    body = box_part((length - 2 * SKIN, width - 2 * SKIN, height - SKIN), (0.0, 0.0, -SKIN / 2), item.board)
    tape = box_part((length, TAPE_WIDTH, TAPE_DROP), (0.0, 0.0, (height - TAPE_DROP) / 2), "tape")
    label = box_part((item.label[0], width, item.label[1]), (0.0, 0.0, -0.1 * height), item.label_material)
    return body, tape, label


def _printed_parts(item: CartonSku, artwork: Artwork) -> tuple[Part, ...]:
    """Return the body with tape, straps or a band around it, the label's paper and all print, one part a material."""
    length, width, height = item.length, item.width, item.height
    skin = 2 * PRINT_SKIN
    body = box_part((length - skin, width - skin, height - PRINT_SKIN), (0.0, 0.0, -PRINT_SKIN / 2), item.board)
    tape = box_part((length, TAPE_WIDTH, TAPE_DROP), (0.0, 0.0, (height - TAPE_DROP) / 2), "tape")
    parts = [body, tape]
    if artwork.band is not None:
        low, high = _band_levels(item)
        centre, band = (0.0, 0.0, (low + high) / 2), (length - PRINT_SKIN, width - PRINT_SKIN, high - low)
        parts.append(box_part(band, centre, artwork.band))
    if artwork.straps:
        parts += [box_part((STRAP_WIDTH, width, height), (s * 0.27 * length, 0.0, 0.0), "strap") for s in (-1, 1)]
    return (*parts, *fused([*_handling_marks(item, artwork), *_brand(item, artwork), *_labels(item)]))


def carton_prints(item: CartonSku) -> list[Part]:
    """Return all that is on the four sides of a carton, between the board and the outer size, and nothing within."""
    size, half = (item.length, item.width, item.height), 0.5 * PRINT_SKIN
    if item.artwork is None:
        width, height = item.label
        label = moved((rectangle(-width / 2, -height / 2, width / 2, height / 2),), 0.0, -0.1 * item.height)
        return [part for side in _LONG_SIDES for part in on_side(label, side, size, item.label_material, 0.0, half)]
    parts = [*_handling_marks(item, item.artwork), *_brand(item, item.artwork), *_labels(item)]
    if item.artwork.band is not None:
        low, high = _band_levels(item)
        for side in (*_LONG_SIDES, *_SHORT_SIDES):
            edge = (item.length if side in _LONG_SIDES else item.width) - 2 * PRINT_SKIN
            parts += on_side(
                (rectangle(-edge / 2, low, edge / 2, high),), side, size, item.artwork.band, half, 0.4 * half
            )
    return parts


def _band_levels(item: CartonSku) -> tuple[float, float]:
    """Return lower and upper height (m, object frame) of the coloured band."""
    return 0.08 * item.height, 0.40 * item.height


def _handling_marks(item: CartonSku, artwork: Artwork) -> list[Part]:
    """Return the marks in the lower left of all four sides, and the holes to grip."""
    size, height = (item.length, item.width, item.height), min(0.26 * item.height, 0.075)
    bottom = -item.height / 2 + _MARGIN + height / 2
    parts = []
    for side in (*_LONG_SIDES, *_SHORT_SIDES):
        edge = item.length if side in _LONG_SIDES else item.width
        # The label keeps its place: what does not fit beside it is left out.
        free = edge - 2 * _MARGIN - (item.label[0] if side in _LABELLED else 0.0)
        for i, mark in enumerate(artwork.marks[: int(free / (1.1 * height))]):
            left = -edge / 2 + _MARGIN + height / 2 + 1.1 * i * height
            parts += on_side(moved(handling_mark(mark, height), left, bottom), side, size, artwork.ink, 0.0, _INK)
    if artwork.hand_holes:
        hole = moved((_stadium(0.09, 0.028),), 0.0, item.height / 2 - TAPE_DROP - 0.04)
        for side in _SHORT_SIDES:
            parts += on_side(hole, side, size, "print_dark", 0.0, _INK)
    return parts


def _brand(item: CartonSku, artwork: Artwork) -> list[Part]:
    """Return the brand on the long sides: on the left in ink, or in white in the middle of the band."""
    low, high = _band_levels(item)
    letters = min(0.6 * (high - low), 0.6 * item.length * 6 / (5 * len(artwork.brand)))
    on_band = artwork.band is not None
    x = 0.0 if on_band else -item.length / 2 + _MARGIN + word_width(artwork.brand, letters) / 2
    shapes = moved(word(artwork.brand, letters), x, (low + high) / 2)
    size, material = (item.length, item.width, item.height), "label_paper" if on_band else artwork.ink
    return [
        part
        for side in _LONG_SIDES
        for part in on_side(shapes, side, size, material, 0.0, _INK if artwork.band is None else 0.4 * PRINT_SKIN)
    ]


def _labels(item: CartonSku) -> list[Part]:
    """Return the shipping label on one long and the next short side: paper, address lines, barcode."""
    size, (width, height) = (item.length, item.width, item.height), item.label
    y = min(0.032 - (item.height - height) / 2, 0.0)
    paper = rectangle(-width / 2, -height / 2, width / 2, height / 2)
    parts = []
    for side, edge in zip(_LABELLED, (item.length, item.width), strict=True):
        x = edge / 2 - _MARGIN - width / 2
        parts += on_side(moved((paper,), x, y), side, size, "label_paper", PRINT_SKIN / 2, 0.4 * PRINT_SKIN)
        parts += on_side(moved(_label_ink(item), x, y), side, size, "print_dark", 0.0, PRINT_SKIN / 2)
    return parts


def _label_ink(item: CartonSku) -> Shapes:
    """Return what is printed on the label, centred on it: lines of text, a rule, the barcode and its number."""
    width, height = item.label
    inner = 0.88 * width
    lines = text_lines(inner, 0.30 * height, (0.45, 0.8, 0.62, 0.3))
    rule = rectangle(-inner / 2, 0.05 * height, inner / 2, 0.07 * height)
    number = text_lines(0.6 * inner, 0.06 * height, (1.0,))
    return (
        *moved(lines, 0.0, 0.28 * height),
        rule,
        *moved(barcode(item.obj_id, 0.8 * inner, 0.32 * height), 0.0, -0.16 * height),
        *moved(number, 0.0, -0.41 * height),
    )


def _stadium(width: float, height: float) -> tuple[tuple[float, float], ...]:
    """Return a bar with round ends (m)."""
    radius, half = height / 2, (width - height) / 2
    right = [
        (half + radius * float(np.cos(a)), radius * float(np.sin(a))) for a in np.linspace(-np.pi / 2, np.pi / 2, 7)
    ]
    return (*right, *((-x, -y) for x, y in right))
