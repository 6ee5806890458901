"""Euro containers: the stacking containers of VDA 4500, open or with a lid, filled with goods.

VDA 4500 gives the real sizes 594 x 396 and 396 x 297 mm for the modules 600 x 400 and 400 x 300, and the heights 147.5
and 280 mm. Real ones sink 15 mm into the rim of the one below; here they stand on it. One that is carried by hand
weighs at most 15 kg with its goods.
"""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog.loads.artwork import barcode, moved, on_side, rectangle, text_lines
from warehouse_sim.catalog.loads.cages import ring
from warehouse_sim.catalog.parts import Triple, box_part, fused, model_of, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.schema import ObjectModel, Part

_WALL, _RIM, _RIM_HEIGHT = 0.004, 0.013, 0.022
"""Thickness of a wall, width of the rim around it and height of the rim (m)."""
_FOOT_HEIGHT, _FOOT_INSET = 0.015, 0.011
_RIB_PITCH, _RIB = 0.075, 0.004
_HANDLE = (0.12, 0.04)
"""Width and height of the grip holes in the short sides (m); VDA containers have about 12 x 4 cm."""
_LID = 0.012


@dataclass(frozen=True)
class ToteSku:
    """One geometry of container."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    module: str
    """Nominal size in the name."""
    length: float
    """Outer edge along x (m)."""
    width: float
    """Outer edge along y (m)."""
    height: float
    """Outer edge along z (m)."""
    mass: float
    """Kilograms with goods."""
    lid: bool = False
    """Whether it is closed."""


_SKUS = (
    ToteSku(29, "600x400x280", 0.594, 0.396, 0.280, 15.0),
    ToteSku(30, "600x400x147", 0.594, 0.396, 0.1475, 12.0),
    ToteSku(31, "400x300x280", 0.396, 0.297, 0.280, 11.0),
    ToteSku(32, "400x300x147", 0.396, 0.297, 0.1475, 8.0),
    ToteSku(33, "600x400x280_lid", 0.594, 0.396, 0.280, 14.0, lid=True),
)
_COLORS = {"grey": "plastic_grey", "blue": "plastic_blue", "red": "plastic_red"}
TOTES = {f"tote_{sku.module}_{color}": (sku, material) for sku in _SKUS for color, material in _COLORS.items()}
"""Catalog name -> geometry and material; the colours of one size are one geometry."""


def tote(name: str) -> ObjectModel:
    """Build the container called ``name`` ("tote_600x400x280_grey")."""
    sku, material = TOTES[name]
    size = (sku.length, sku.width, sku.height)
    shell = [replace(part, material=material) for part in (*_shell(sku), *(_lid(sku) if sku.lid else ()))]
    return model_of(
        name,
        "tote",
        sku.obj_id,
        size,
        fused([*shell, *_label(sku), *([] if sku.lid else _goods(sku))]),
        (solid_box(size),) if sku.lid else _hollow(sku),
        mass=sku.mass,
    )


def _shell(sku: ToteSku) -> list[Part]:
    """Return foot, floor, walls with grip holes, ribs and rim."""
    length, width, height = sku.length, sku.width, sku.height
    low, high = -height / 2, height / 2 - (_LID if sku.lid else 0.0)
    inset = 2 * _RIM
    foot = (length - 2 * _FOOT_INSET - inset / 2, width - 2 * _FOOT_INSET - inset / 2, _FOOT_HEIGHT)
    pieces = [_box(foot, (0, 0, low + _FOOT_HEIGHT / 2))]
    floor = low + _FOOT_HEIGHT
    pieces.append(_box((length - inset, width - inset, _WALL), (0, 0, floor + _WALL / 2)))
    pieces += _walls(length - inset, width - inset, floor, high)
    pieces += ring(length, width, high - _RIM_HEIGHT, high, _RIM + _WALL, "plastic_grey")
    pieces += ring(length - 0.004, width - 0.004, floor, floor + 0.012, _RIM, "plastic_grey")
    return [*pieces, *_ribs(length, width, floor + 0.012, high - _RIM_HEIGHT)]


def _walls(length: float, width: float, low: float, high: float) -> list[Part]:
    """Return four walls with outer faces ``length`` and ``width`` (m) apart and a grip hole in the short ones."""
    centre, rise = (low + high) / 2, high - low
    pieces = [_box((length, _WALL, rise), (0, s * (width - _WALL) / 2, centre)) for s in (-1, 1)]
    wide, tall = _HANDLE
    hole_top = high - _RIM_HEIGHT
    hole_low = hole_top - tall
    side = (width - wide) / 2
    for s in (-1, 1):
        x = s * (length - _WALL) / 2
        pieces.append(_box((_WALL, width, hole_low - low), (x, 0, (low + hole_low) / 2)))
        pieces.append(_box((_WALL, width, high - hole_top), (x, 0, (hole_top + high) / 2)))
        pieces += [_box((_WALL, side, tall), (x, t * (width - side) / 2, hole_low + tall / 2)) for t in (-1, 1)]
        # A collar around the hole stands out as far as the rim.
        collar = x + s * (_WALL + _RIM - 0.002) / 2
        pieces += [
            _box((_RIM - 0.002, 0.006, tall), (collar, t * (wide / 2 + 0.003), hole_low + tall / 2)) for t in (-1, 1)
        ]
        pieces.append(_box((_RIM - 0.002, wide + 0.012, 0.006), (collar, 0, hole_low - 0.003)))
    return pieces


def _ribs(length: float, width: float, low: float, high: float) -> list[Part]:
    """Return upright ribs on the walls; the middle of the short sides is kept for the grip and its collar."""
    centre, rise, depth = (low + high) / 2, high - low, _RIM - 0.003
    pieces = []
    for x in _stations(length - 0.06):
        pieces += [_box((_RIB, depth, rise), (x, s * (width / 2 - _RIM + depth / 2), centre)) for s in (-1, 1)]
    for y in _stations(width - 0.06):
        if abs(y) > _HANDLE[0] / 2 + 0.01:
            pieces += [_box((depth, _RIB, rise), (s * (length / 2 - _RIM + depth / 2), y, centre)) for s in (-1, 1)]
    return pieces


def _lid(sku: ToteSku) -> list[Part]:
    """Return two halves that meet in the middle, each with a raised field."""
    top, half = sku.height / 2, sku.length / 2 - 0.002
    pieces = []
    for s in (-1, 1):
        x = s * (half / 2 + 0.002)
        pieces.append(_box((half, sku.width, _LID - 0.004), (x, 0, top - _LID + (_LID - 0.004) / 2)))
        pieces.append(_box((half - 0.05, sku.width - 0.06, 0.004), (x, 0, top - 0.002)))
    return pieces


def _label(sku: ToteSku) -> list[Part]:
    """Return the card (210 x 74 mm where it fits) with a barcode in front of one long side."""
    width, height = min(0.21, 0.5 * sku.length), min(0.074, 0.45 * sku.height)
    size = (sku.length, sku.width, sku.height)
    card = on_side(
        (rectangle(-width / 2, -height / 2, width / 2, height / 2),), "+y", size, "label_paper", 0.001, 0.006
    )
    lines = moved(text_lines(0.42 * width, 0.6 * height, (1.0, 0.7, 0.85)), -0.24 * width, 0.0)
    ink = (*lines, *moved(barcode(sku.obj_id, 0.4 * width, 0.6 * height, 14), 0.25 * width, 0.0))
    return [*card, *on_side(ink, "+y", size, "print_dark", 0.0, 0.0015)]


def _goods(sku: ToteSku) -> list[Part]:
    """Return boxes that fill the container to a little under its rim, so that it is not empty seen from above."""
    pieces = []
    for number, (size, centre) in enumerate(_filling(sku)):
        pieces.append(box_part(size, centre, ("kraft", "board_white", "kraft_light")[number % 3]))
    return pieces


def _filling(sku: ToteSku) -> list[tuple[Triple, Triple]]:
    """Return edge lengths and centre (m) of each box in the container."""
    inner = np.array([sku.length, sku.width]) - 2 * (_RIM + _WALL) - 0.004
    floor, free = -sku.height / 2 + _FOOT_HEIGHT + _WALL, sku.height - _RIM_HEIGHT - _FOOT_HEIGHT - 0.01
    columns, rows = (3, 2) if sku.length > 0.5 else (2, 2)
    cell = inner / (columns, rows)
    fractions = np.random.default_rng(sku.obj_id).uniform(0.6, 1.0, (columns, rows))
    found: list[tuple[Triple, Triple]] = []
    for i in range(columns):
        for j in range(rows):
            tall = float(free * fractions[i, j])
            centre = (np.array([i, j]) + 0.5) * cell - inner / 2
            x, y = (cell - 0.004).tolist()
            found.append(((x, y, tall), (float(centre[0]), float(centre[1]), floor + tall / 2)))
    return found


def _hollow(sku: ToteSku) -> tuple[OrientedBox, ...]:
    """Return bottom, walls as thick as the rim, and the goods between them, over which more may lie.

    The bottom is as large as the rim, so that a container stands on the one below and sinks nowhere.
    """
    thick, base = _RIM + _WALL, _FOOT_HEIGHT + _WALL
    rise, centre = sku.height - base, base / 2
    walls = [solid_box((sku.length, thick, rise), (0.0, s * (sku.width - thick) / 2, centre)) for s in (-1, 1)]
    short = (thick, sku.width - 2 * thick, rise)
    walls += [solid_box(short, (s * (sku.length - thick) / 2, 0.0, centre)) for s in (-1, 1)]
    bottom = solid_box((sku.length, sku.width, base), (0.0, 0.0, (base - sku.height) / 2))
    return (bottom, *walls, *(solid_box(size, place) for size, place in _filling(sku)))


def _stations(span: float) -> np.ndarray:
    """Return evenly spaced places on ``span`` (m), ends included."""
    return np.linspace(-span / 2, span / 2, max(2, round(span / _RIB_PITCH) + 1))


def _box(size: tuple[float, ...], centre: tuple[float, ...]) -> Part:
    return box_part(size, centre, "plastic_grey")
