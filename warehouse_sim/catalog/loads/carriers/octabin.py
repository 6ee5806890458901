"""Octabins: eight-sided boxes of heavy corrugated board for granules, with a lid, standing on a pallet alone.

They hold 300-1,100 kg; footprints follow the pallet, 1,160 x 960 mm on 1,200 x 1,000 and 1,160 x 760 mm on 1,200 x 800,
heights 800-1,900 mm (common in makers' lists, unverified). Plastic granules weigh 0.5-0.6 t/m^3 in bulk.
"""

from dataclasses import dataclass

from warehouse_sim.catalog.loads.artwork import (
    Side,
    barcode,
    handling_mark,
    moved,
    on_side,
    rectangle,
    text_lines,
    word,
)
from warehouse_sim.catalog.parts import fused, model_of, slab_part, solid_box
from warehouse_sim.geometry.solids import Outline
from warehouse_sim.schema import ObjectModel, Part

_LID, _SKIN = 0.12, 0.004
"""Height of the lid's sides and how far they stand out (m)."""


@dataclass(frozen=True)
class OctabinSku:
    """One geometry of octabin."""

    obj_id: int
    length: float
    width: float
    height: float
    cut: float
    """How much the corners take of each edge (m)."""
    mass: float
    board: str
    brand: str


OCTABINS = {
    "octabin_1160x960x1200": OctabinSku(321, 1.16, 0.96, 1.20, 0.22, 640.0, "kraft", "POLENE"),
    "octabin_1160x960x950": OctabinSku(322, 1.16, 0.96, 0.95, 0.22, 500.0, "kraft_light", "NATUPEL"),
    "octabin_1160x760x1050": OctabinSku(323, 1.16, 0.76, 1.05, 0.18, 430.0, "kraft_dark", "LUPOL"),
    "octabin_1160x760x1350": OctabinSku(324, 1.16, 0.76, 1.35, 0.18, 560.0, "kraft", "CELOPAN"),
}
"""Catalog name -> geometry."""


def octabin(name: str) -> ObjectModel:
    """Build the octabin called ``name`` ("octabin_1160x960x1200")."""
    sku = OCTABINS[name]
    body = _octagon(sku.length - 2 * _SKIN, sku.width - 2 * _SKIN, sku.cut)
    lid = _octagon(sku.length, sku.width, sku.cut)
    parts = [
        slab_part(body, -sku.height / 2, sku.height / 2 - 0.003, sku.board),
        slab_part(lid, sku.height / 2 - _LID, sku.height / 2, "kraft_light" if sku.board == "kraft" else "kraft"),
        *(
            slab_part(_octagon(sku.length - 0.004, sku.width - 0.004, sku.cut), z, z + 0.016, "strap")
            for z in _bands(sku)
        ),
    ]
    cut = sku.cut
    return model_of(
        name,
        "octabin",
        sku.obj_id,
        (sku.length, sku.width, sku.height),
        fused([*parts, *_print(sku)]),
        (
            solid_box((sku.length, sku.width - 2 * cut, sku.height)),
            solid_box((sku.length - 2 * cut, sku.width, sku.height)),
        ),
        mass=sku.mass,
    )


def _octagon(length: float, width: float, cut: float) -> Outline:
    x, y = length / 2, width / 2
    return ((x - cut, -y), (x, cut - y), (x, y - cut), (x - cut, y), (cut - x, y), (-x, y - cut), (-x, cut - y),
            (cut - x, -y))  # fmt: skip


def _bands(sku: OctabinSku) -> list[float]:
    """Return the heights (m) of the bands that hold the bulging board."""
    return [-sku.height / 2 + fraction * sku.height for fraction in (0.18, 0.42, 0.66)]


def _print(sku: OctabinSku) -> list[Part]:
    """Return brand, marks and a label on the long sides, a label on one short side."""
    size = (sku.length, sku.width, sku.height)
    ink = [*moved(word(sku.brand, 0.11), 0.0, 0.10 * sku.height)]
    ink += moved(handling_mark("up", 0.12), -0.2, -0.12 * sku.height)
    ink += moved(handling_mark("dry", 0.12), -0.05, -0.12 * sku.height)
    pieces: list[Part] = []
    long_sides: tuple[Side, ...] = ("-y", "+y")
    for side in long_sides:
        pieces += on_side(tuple(ink), side, size, "print_blue", 0.002, 0.003)
    label = moved((rectangle(-0.105, -0.074, 0.105, 0.074),), 0.15, -0.13 * sku.height)
    lines = (
        *moved(text_lines(0.18, 0.05, (0.9, 0.6, 0.8)), 0.0, 0.04),
        *moved(barcode(sku.obj_id, 0.16, 0.05), 0.0, -0.03),
    )
    labelled: tuple[Side, ...] = ("-y", "+x")
    for side in labelled:
        pieces += on_side(label, side, size, "label_paper", 0.001, 0.004)
        pieces += on_side(moved(lines, 0.15, -0.13 * sku.height), side, size, "print_dark", 0.0, 0.002)
    return pieces
