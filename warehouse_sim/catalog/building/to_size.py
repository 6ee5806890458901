"""The hall's shell built to size: slab, walls with openings, roof, trusses and columns.

Frames as in ``shell`` and ``structure``: origin at the centre of the bounding box, z up, x along a wall. Equal sizes
share one model; the name says the size in millimetres. All that is flat stays a few large boxes, so that a hall of
120 m costs a renderer no more than one of 20 m.
"""

from functools import cache
from typing import Literal

import numpy as np

from warehouse_sim.catalog.building.shell import FLOOR_SIZE, WALL_SIZE, jointed_parts, ribbed_sheet
from warehouse_sim.catalog.building.structure import CEILING_SIZE, ceiling, column_concrete, column_steel, roof_truss
from warehouse_sim.catalog.parts import box_part, fused, model_of, solid_box
from warehouse_sim.schema import ObjectModel, Part

WallKind = Literal["panels", "cladding", "sandwich", "blockwork", "plaster"]
FloorKind = Literal["concrete", "jointed", "epoxy"]
RoofKind = Literal["truss", "beam", "board"]
Opening = tuple[float, float, float]
"""Middle along the wall, width and height from the floor (m)."""

WALL_THICKNESS = WALL_SIZE[1]
"""Of every wall (m)."""
_PLINTH, _FRAME = 0.4, 0.1
_SANDWICH_PANEL = 1.1  # width of a foamed panel that stands upright (m); 1.0-1.2 are usual
_SEAM, _RELIEF = 0.012, 0.003  # between two of them, and how far its cover stands out of both faces together (m)
_FACES: dict[str, tuple[str, str]] = {
    "panels": ("concrete", "wall_paint"),
    "sandwich": ("concrete", "panel_white"),
    "blockwork": ("blockwork_dark", "blockwork"),
    "plaster": ("wall_paint", "wall_paint"),
    "cladding": ("concrete", "cladding"),
}
"""Kind of wall -> materials of its plinth and of what stands on it."""
_BOARD = 0.6  # edge of a ceiling board, with its bearer (m)


@cache
def slab_to_size(kind: FloorKind, length: float, width: float) -> ObjectModel:
    """Build the floor, ``length`` x ``width`` m; its top is 0.1 m above its centre."""
    size = (length, width, FLOOR_SIZE[2])
    name = f"slab_{kind}_{_mm(length)}x{_mm(width)}"
    if kind == "concrete":
        return model_of(
            name,
            "floor",
            400,
            size,
            (box_part(size, (0.0, 0.0, 0.0), "concrete"),),
            turns=2,
        )
    parts = jointed_parts(size, {"jointed": "concrete", "epoxy": "epoxy_grey"}[kind])
    return model_of(name, "floor", 401, size, parts, turns=2)


@cache
def wall_to_size(kind: WallKind, length: float, height: float, openings: tuple[Opening, ...] = ()) -> ObjectModel:
    """Build a wall with openings that reach down to the floor, each in a flat frame of steel.

    Args:
        kind: What it is made of.
        length: Along x (m).
        height: Of the wall (m).
        openings: In order from -x, at least 0.2 m apart.
    """
    size = (length, WALL_THICKNESS, height)
    foot, left, pieces = -height / 2, -length / 2, []
    parts: list[Part] = []
    for middle, width, tall in openings:
        edge = width / 2 + _FRAME
        pieces += [(left, middle - edge, foot), (middle - edge, middle + edge, foot + tall + _FRAME)]
        parts += _door_frame(middle, width, tall, foot)
        left = middle + edge
    pieces.append((left, length / 2, foot))
    for start, end, low in pieces:
        parts += _stretch(kind, start, end, low, height)
    solid = [
        solid_box((end - start, WALL_THICKNESS, -foot - low), ((start + end) / 2, 0.0, (low - foot) / 2))
        for start, end, low in pieces
    ]
    holes = "".join(f"_{_mm(at)}_{_mm(width)}x{_mm(tall)}" for at, width, tall in openings)
    name = f"wall_{kind}_{_mm(length)}x{_mm(height)}{holes}"
    return model_of(name, "wall", 402, size, fused(parts), solid, turns=1 if openings else 2)


@cache
def roof_to_size(kind: RoofKind, length: float, width: float) -> ObjectModel:
    """Build the roof from below: trapezoidal sheet on purlins, or the white boards of a suspended ceiling."""
    size = (length, width, CEILING_SIZE[2])
    name = f"roof_{'board' if kind == 'board' else 'sheet'}_{_mm(length)}x{_mm(width)}"
    if kind != "board":
        return ceiling(name, size)
    boards = box_part((length, width, size[2] - 0.004), (0.0, 0.0, 0.002), "ceiling_board")
    low, bar = 0.002 - size[2] / 2, 0.024
    bars = [box_part((length, bar, 0.004), (0.0, y, low), "sign_white") for y in _spread(width - bar, _BOARD)]
    bars += [box_part((bar, width, 0.003), (x, 0.0, low + 0.0005), "sign_white") for x in _spread(length, 2 * _BOARD)]
    return model_of(name, "ceiling", 403, size, (boards, *fused(bars)), turns=2)


@cache
def girder_to_size(kind: RoofKind, span: float) -> ObjectModel:
    """Build what carries the roof over ``span`` m along x: a truss, or a beam with two flanges."""
    if kind == "truss":
        return roof_truss(f"roof_truss_{_mm(span)}", (span, 0.2 if span > 24.0 else 0.14, girder_depth(kind, span)))
    depth, flange, web = girder_depth(kind, span), 0.02, 0.012
    size = (span, 0.22, depth)
    parts = [box_part((span, 0.22, flange), (0.0, 0.0, side * (depth - flange) / 2), "steel_grey") for side in (-1, 1)]
    parts.append(box_part((span, web, depth - 2 * flange), (0.0, 0.0, 0.0), "steel_grey"))
    return model_of(f"roof_beam_{_mm(span)}", "ceiling", 404, size, fused(parts), turns=2)


def girder_depth(kind: RoofKind, span: float) -> float:
    """Return how far girders hang below the roof (m): about a 22nd of a truss's span, a 35th of a beam's."""
    if kind == "board":
        return 0.0
    return float(np.clip(span / 22.0, 0.6, 1.8)) if kind == "truss" else float(np.clip(span / 35.0, 0.3, 0.9))


@cache
def column_to_size(kind: Literal["steel", "concrete"], height: float) -> ObjectModel:
    """Build a column, ``height`` m high."""
    return (column_steel if kind == "steel" else column_concrete)(f"column_{kind}_{_mm(height)}", height)


def _stretch(kind: str, start: float, end: float, low: float, height: float) -> list[Part]:
    """Return the wall between ``start`` and ``end`` (m along x) from ``low`` to its top."""
    length, middle, top = end - start, (start + end) / 2, height / 2
    plinth, face = _FACES[kind]
    above = max(low, _PLINTH - top)
    parts = []
    if above > low:
        parts.append(box_part((length, WALL_THICKNESS, above - low), (middle, 0.0, (low + above) / 2), plinth))
    if kind == "cladding":
        return [*parts, ribbed_sheet(start, end, above, top)]
    tall = top - above
    thick = WALL_THICKNESS - (_RELIEF if kind == "sandwich" else 0.0)
    parts.append(box_part((length, thick, tall), (middle, 0.0, (top + above) / 2), face))
    if kind == "sandwich":
        first, last = np.ceil(start / _SANDWICH_PANEL + 0.05), np.floor(end / _SANDWICH_PANEL - 0.05)
        size = (_SEAM, WALL_THICKNESS, tall)
        parts += [
            box_part(size, (number * _SANDWICH_PANEL, 0.0, (top + above) / 2), "panel_seam")
            for number in np.arange(first, last + 1)
        ]
    return parts


def _door_frame(middle: float, width: float, tall: float, foot: float) -> list[Part]:
    """Return jambs and lintel around an opening."""
    jamb = (_FRAME, WALL_THICKNESS, tall + _FRAME)
    parts = [
        box_part(jamb, (middle + side * (width + _FRAME) / 2, 0.0, foot + jamb[2] / 2), "galvanised")
        for side in (-1.0, 1.0)
    ]
    lintel = (middle, 0.0, foot + tall + _FRAME / 2)
    return [*parts, box_part((width, WALL_THICKNESS, _FRAME), lintel, "galvanised")]


def _spread(length: float, pitch: float) -> list[float]:
    """Return places (m) ``pitch`` apart, even about 0, within ``length``."""
    half = int(length / 2 / pitch)
    return [number * pitch for number in range(-half, half + 1)]


def _mm(metres: float) -> int:
    return round(1000 * metres)
