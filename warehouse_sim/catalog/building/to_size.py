"""The hall built to size: slab, walls with openings, roof, trusses and columns, and what hangs under the roof.

Frames as in ``shell`` and ``structure``: origin at the centre of the bounding box, z up, x along a wall or a line.
Equal sizes share one model; the name says the size in millimetres. All that is flat stays a few large boxes, and what
hangs is a few long parts, so that a hall of 120 m costs a renderer no more than one of 20 m. What hangs (sprinkler
pipes, cable trays, ducts, light lines, rooflights, windows) has no collision boxes: it hangs where nothing moves.
"""

from functools import cache
from typing import Literal

import numpy as np

from warehouse_sim.catalog.building.shell import FLOOR_SIZE, WALL_SIZE, jointed_parts, ribbed_sheet
from warehouse_sim.catalog.building.structure import CEILING_SIZE, ceiling, column_concrete, column_steel, roof_truss
from warehouse_sim.catalog.parts import box_part, fused, model_of, solid_box, solid_part
from warehouse_sim.geometry.pose import rotation_y
from warehouse_sim.geometry.solids import unit_cylinder
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


HEAD_PITCH = 3.0
"""Distance between sprinkler heads (m): 9-12 m^2 a head at usual distances between pipes (EN 12845)."""
_ALONG_X = rotation_y(np.pi / 2)


@cache
def sprinkler_line(length: float) -> ObjectModel:
    """Build a red pipe of 60 mm along x with a head hanging from it every 3 m, ``length`` m long."""
    pipe, flange = 0.06, 0.1
    size = (length, flange, 0.18)
    top = (size[2] - flange) / 2
    parts = [solid_part(unit_cylinder(8), (pipe, pipe, length), (0.0, 0.0, top), "pipe_red", _ALONG_X)]
    parts += [
        solid_part(unit_cylinder(12), (flange, flange, 0.03), (x, 0.0, top), "pipe_red", _ALONG_X)
        for x in np.arange(-length / 2 + 3.0, length / 2 - 0.5, 6.0)
    ]
    heads = []
    for x in np.arange(-length / 2 + HEAD_PITCH / 2, length / 2, HEAD_PITCH):
        heads.append(box_part((0.02, 0.02, 0.09), (x, 0.0, 0.045 + 0.02 - size[2] / 2), "chrome"))
        heads.append(solid_part(unit_cylinder(8), (0.05, 0.05, 0.02), (x, 0.0, 0.01 - size[2] / 2), "chrome"))
    return model_of(f"sprinkler_line_{_mm(length)}", "service", 410, size, fused([*parts, *heads]), (), turns=2)


@cache
def cable_tray(length: float) -> ObjectModel:
    """Build a galvanised tray of 300 x 60 mm along x with a bundle of dark cables in it."""
    width, height, sheet = 0.3, 0.06, 0.003
    size = (length, width, height)
    parts = [box_part((length, width, sheet), (0.0, 0.0, (sheet - height) / 2), "galvanised")]
    for side in (-1.0, 1.0):
        parts.append(
            box_part((length, sheet, height - sheet), (0.0, side * (width - sheet) / 2, sheet / 2), "galvanised")
        )
    for y, wide, tall in ((-0.07, 0.10, 0.03), (0.04, 0.06, 0.025), (0.11, 0.03, 0.018)):
        at = (0.0, y, sheet - height / 2 + tall / 2)
        parts.append(box_part((length - 0.02, wide, tall), at, "plastic_black"))
    return model_of(f"cable_tray_{_mm(length)}", "service", 411, size, fused(parts), (), turns=1)


@cache
def duct(length: float) -> ObjectModel:
    """Build a round ventilation duct of 500 mm along x: galvanised, a collar every 3 m and an outlet between two."""
    bore, collar = 0.5, 0.54
    size = (length, collar, collar + 0.1)
    z = 0.05
    parts = [solid_part(unit_cylinder(20), (bore, bore, length), (0.0, 0.0, z), "galvanised", _ALONG_X)]
    for x in np.arange(-length / 2 + 1.5, length / 2, 3.0):
        parts.append(solid_part(unit_cylinder(20), (collar, collar, 0.05), (x, 0.0, z), "galvanised", _ALONG_X))
    for x in np.arange(-length / 2 + 3.0, length / 2 - 0.5, 3.0):
        parts.append(box_part((0.6, 0.18, 0.1), (x, 0.0, 0.05 - size[2] / 2), "galvanised"))
        parts.append(box_part((0.54, 0.12, 0.004), (x, 0.0, 0.003 - size[2] / 2), "mast_black"))
    return model_of(f"duct_{_mm(length)}", "service", 412, size, fused(parts), ())


@cache
def light_line(length: float) -> ObjectModel:
    """Build a row of trunking luminaires along x, 2.9 m each; what it glows with is that of a scene's luminaires."""
    width, height, glow = 0.08, 0.09, 0.03
    parts = [box_part((length, width, height - glow), (0.0, 0.0, glow / 2), "sign_white")]
    count = max(int(length / 3.0), 1)
    for x in (np.arange(count) - (count - 1) / 2) * length / count:
        parts.append(box_part((length / count - 0.12, width - 0.015, glow), (x, 0.0, (glow - height) / 2), "led_row"))
    size = (length, width, height)
    return model_of(f"light_line_{_mm(length)}", "luminaire", 413, size, fused(parts), (), turns=2)


@cache
def rooflight(length: float, width: float = 1.6) -> ObjectModel:
    """Build a strip of rooflight along x that lies under the roof's sheet: panes of daylight between white bars."""
    height, bar = 0.05, 0.06
    size = (length, width, height)
    parts: list[Part] = [box_part((length - bar, width - bar, 0.02), (0.0, 0.0, 0.01), "outdoor_window")]
    for side in (-1.0, 1.0):
        parts.append(box_part((length, bar, height), (0.0, side * (width - bar) / 2, 0.0), "sign_white"))
    inner, count = width - 2 * bar, max(round(length / 2.0), 1)
    for x in (np.arange(count + 1) / count - 0.5) * (length - bar):
        parts.append(box_part((bar, inner, height), (float(x), 0.0, 0.0), "sign_white"))
    return model_of(f"rooflight_{_mm(length)}", "window", 414, size, fused(parts), (), turns=2)


@cache
def window_band(length: float, height: float = 1.2) -> ObjectModel:
    """Build a band of windows, its back at +y before a wall's inner face: panes of daylight in grey frames."""
    depth, bar = 0.06, 0.07
    size = (length, depth, height)
    parts: list[Part] = [box_part((length - bar, 0.02, height - bar), (0.0, 0.015, 0.0), "outdoor_window")]
    for side in (-1.0, 1.0):
        parts.append(box_part((length, depth, bar), (0.0, 0.0, side * (height - bar) / 2), "steel_grey"))
    inner, count = height - 2 * bar, max(round(length / 1.5), 1)
    for x in (np.arange(count + 1) / count - 0.5) * (length - bar):
        parts.append(box_part((bar, depth, inner), (float(x), 0.0, 0.0), "steel_grey"))
    return model_of(f"window_band_{_mm(length)}x{_mm(height)}", "window", 415, size, fused(parts), ())


@cache
def hanging_rods(length: float) -> ObjectModel:
    """Build two rods, 400 mm apart along x, that something hangs on."""
    rods = [box_part((0.012, 0.012, length), (side * 0.194, 0.0, 0.0), "galvanised") for side in (-1.0, 1.0)]
    return model_of(f"hanging_rods_{_mm(length)}", "service", 416, (0.4, 0.012, length), fused(rods), (), turns=2)
