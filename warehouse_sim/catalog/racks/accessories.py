"""What is added to frames and beams: mesh decks, pallet support bars, guards and labels.

Frame of all: x along the aisle, y into the rack, z up, origin at the centre of the bounding box.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog.loads.artwork import moved, on_side, word
from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, mesh_part, model_of, solid_box
from warehouse_sim.catalog.racks.pallet_racks import BEAM_DEPTH, FRAME_DEPTH, STEP_DEPTH, STEP_HEIGHT
from warehouse_sim.geometry.solids import prism
from warehouse_sim.schema import ObjectModel

MOST_PALLET = 1600
"""What a pallet with its load may weigh (kg) where a rack's drawing sets no limit: a little more than the largest safe
working load of a pallet with the pallet."""
_SIZE = (0.6, 0.004, 0.4)
_INK = 0.0005
_LETTERS = 0.046
"""Height of letters and figures (m), to be read from the driver's seat."""


def load_notice(name: str = "load_notice") -> ObjectModel:
    """Build the notice of a rack whose drawing sets no limit: what a pallet may weigh."""
    return _notice(name, (f"PALLET {MOST_PALLET} KG",))


@cache
def load_notice_of(level: int, levels: int, places: int) -> ObjectModel:
    """Build the notice of a rack.

    Args:
        level: What may stand on a level of a bay (kg).
        levels: Levels of beams in a bay.
        places: Pallets on a level.
    """
    lines = (f"LEVEL {level} KG", f"BAY {level * levels} KG", f"PALLET {level // places} KG")
    return _notice(f"load_notice_{level}x{levels}x{places}", lines)


def _notice(name: str, lines: tuple[str, ...]) -> ObjectModel:
    plate = box_part((_SIZE[0], _SIZE[1] - _INK, _SIZE[2]), (0.0, _INK / 2, 0.0), "sign_white")
    face = -_SIZE[1] / 2 + _INK / 2
    parts = [box_part((0.56, _INK, 0.06), (0.0, face, 0.15), "print_blue")]
    parts.append(box_part((0.56, _INK, 0.012), (0.0, face, -0.185), "print_red"))
    for line, height in zip(lines, np.linspace(0.07, 0.07 - 0.1 * (len(lines) - 1), len(lines)), strict=True):
        parts += on_side(moved(word(line, _LETTERS), 0.0, float(height)), "-y", _SIZE, "print_dark", 0.0, _INK)
    return model_of(name, "sign", 121, _SIZE, (plate, *fused(parts)), mass=1.3)


DECK_DEPTH = FRAME_DEPTH - 2 * (BEAM_DEPTH - STEP_DEPTH) - 0.004
"""Length along y (m) of what lies on the ledges of two step beams, with 2 mm play at each end."""
DECK_WIDTH = 0.88
"""Width of a mesh deck (m); three fill a bay of 2.7 m."""
GUARD_HEIGHT = 0.4
"""Height of the guards of uprights and rack ends (m); EN 15512 requires at least 400 mm."""

_WIRE, _MESH_X, _MESH_Y = 0.005, 0.05, 0.10
_CHANNEL = STEP_HEIGHT - 2 * _WIRE


def mesh_deck(name: str = "mesh_deck") -> ObjectModel:
    """Build a wire deck for step beams: 5 mm wires at 50 x 100 mm on three channels, flush with the beams' tops."""
    top = STEP_HEIGHT / 2
    across = np.linspace(-1.0, 1.0, round(DECK_WIDTH / _MESH_X) + 1) * (DECK_WIDTH - _WIRE) / 2
    along = np.linspace(-1.0, 1.0, round(DECK_DEPTH / _MESH_Y) + 1) * (DECK_DEPTH - _WIRE) / 2
    parts = [box_part((_WIRE, DECK_DEPTH, _WIRE), (x, 0.0, top - _WIRE / 2), "galvanised") for x in across]
    parts += [box_part((DECK_WIDTH, _WIRE, _WIRE), (0.0, y, top - 1.5 * _WIRE), "galvanised") for y in along]
    for x in (-0.35, 0.0, 0.35):
        parts.append(box_part((0.04, DECK_DEPTH, _CHANNEL), (x, 0.0, (_CHANNEL - STEP_HEIGHT) / 2), "galvanised"))
    size = (DECK_WIDTH, DECK_DEPTH, STEP_HEIGHT)
    return model_of(name, "rack", 117, size, fused(parts), turns=2)


def pallet_support_bar(name: str = "pallet_support_bar") -> ObjectModel:
    """Build a bar of 40 mm width that lies across the ledges of two step beams, under a pallet's bottom boards."""
    size = (0.04, DECK_DEPTH, STEP_HEIGHT)
    bar = box_part(size, (0.0, 0.0, 0.0), "galvanised")
    return model_of(name, "rack", 118, size, fused([bar]), turns=2)


def upright_guard(name: str = "upright_guard") -> ObjectModel:
    """Build the bent 6 mm plate, bolted to the floor, that a fork hits instead of the upright; open to +y."""
    width, depth, sheet, foot = 0.17, 0.14, 0.006, 0.01
    x, y, i, j = width / 2 - 0.02, depth / 2, width / 2 - 0.02 - sheet, 0.02
    outline = ((-x, y), (-x, -y + j), (-x + j, -y), (x - j, -y), (x, -y + j), (x, y))
    bend = 0.0025
    right = ((i, y), (i, -y + j + bend), (x - j - bend, -y + sheet))
    inside = (*right, *((-a, b) for a, b in reversed(right)))
    bent = mesh_part(prism((*outline, *inside), GUARD_HEIGHT - foot), "guard_yellow", (0.0, 0.0, foot / 2))
    plate = box_part((width, depth, foot), (0.0, 0.0, (foot - GUARD_HEIGHT) / 2), "guard_yellow")
    band = [(side * (x - sheet / 2), 0.0, foot / 2) for side in (-1.0, 1.0)]
    sides = [solid_box((sheet, depth, GUARD_HEIGHT - foot), at) for at in band]
    front = solid_box((2 * x, j + sheet, GUARD_HEIGHT - foot), (0.0, -y + (j + sheet) / 2, foot / 2))
    return model_of(
        name,
        "guard",
        119,
        (width, depth, GUARD_HEIGHT),
        fused([plate, bent]),
        (front, *sides, *collision_boxes([plate])),
        mass=4.5,
    )


def rack_end_guard(name: str = "rack_end_guard") -> ObjectModel:
    """Build the barrier before a rack's end: two posts and two rails, yellow and black; 1.2 m long along y."""
    length, post, rail = 1.2, 0.12, 0.05
    plate = (post, 0.2, 0.01)
    posts = [
        box_part((0.06, 0.10, GUARD_HEIGHT), (0.0, side * (length - 0.2) / 2, 0.0), "guard_black")
        for side in (-1.0, 1.0)
    ]
    feet = [
        box_part(plate, (0.0, side * (length - plate[1]) / 2, (plate[2] - GUARD_HEIGHT) / 2), "guard_black")
        for side in (-1.0, 1.0)
    ]
    rails = []
    for z in (-0.06, 0.13):
        span, pieces = length, 8
        for index in range(pieces):
            y = (index - (pieces - 1) / 2) * span / pieces
            paint = "guard_yellow" if index % 2 == 0 else "guard_black"
            rails.append(box_part((rail, span / pieces, 0.1), (0.03 + rail / 2 - 0.02, y, z), paint))
    parts = [*posts, *feet, *rails]
    solid = [box_part((rail, length, 0.1), (0.01 + rail / 2, 0.0, z), "guard_yellow") for z in (-0.06, 0.13)]
    return model_of(
        name,
        "guard",
        120,
        (post, length, GUARD_HEIGHT),
        fused(parts),
        collision_boxes([*posts, *feet, *solid]),
        mass=28.0,
    )


def beam_label(name: str = "beam_label") -> ObjectModel:
    """Build a location's label, 105 x 74 mm (A7), face at -y: white foil with the bars of a code and a line of text."""
    width, height, ink = 0.105, 0.074, 0.0004
    plate = box_part((width, 0.001 - ink, height), (0.0, ink / 2, 0.0), "sign_white")
    face = -0.0005 + ink / 2
    # 23 modules: bars and gaps of one or two modules each, as in Code 128.
    bars, x = [], -0.046
    for bar, gap in ((2, 1), (1, 2), (2, 2), (1, 1), (1, 2), (2, 1), (1, 1), (2, 1)):
        wide = 0.004 * bar
        bars.append(box_part((wide, ink, 0.034), (x + wide / 2, face, -0.014), "print_dark"))
        x += wide + 0.004 * gap
    text = [box_part((0.013, ink, 0.016), (at, face, 0.02), "print_dark") for at in np.linspace(-0.036, 0.036, 5)]
    return model_of(name, "sign", 503, (width, 0.001, height), fused([plate, *bars, *text]), mass=0.01)


def frame_label(name: str = "frame_label") -> ObjectModel:
    """Build the number of a bay on its upright, 95 x 148 mm (narrow A6), face at -y: yellow with two dark figures."""
    width, height, ink = 0.095, 0.148, 0.0005
    plate = box_part((width, 0.002 - ink, height), (0.0, ink / 2, 0.0), "guard_yellow")
    face = -0.001 + ink / 2
    marks = [((0.016, ink, 0.08), (-0.024, face, 0.02)), ((0.034, ink, 0.016), (0.02, face, 0.052))]
    marks += [((0.034, ink, 0.016), (0.02, face, -0.012)), ((0.016, ink, 0.048), (0.011, face, 0.02))]
    marks += [((0.07, ink, 0.02), (0.0, face, -0.052))]
    figures = [box_part(*mark, "guard_black") for mark in marks]
    return model_of(name, "sign", 504, (width, 0.002, height), fused([plate, *figures]), mass=0.05)


def row_spacer(name: str = "row_spacer") -> ObjectModel:
    """Build the tie between the frames of racks back to back: a channel of 60 x 40 mm, 300 mm along y, with plates."""
    length = 0.3
    body = box_part((0.04, length - 0.012, 0.06), (0.0, 0.0, 0.0), "rack_blue")
    ends = [box_part((0.08, 0.006, 0.1), (0.0, side * (length - 0.006) / 2, 0.0), "galvanised") for side in (-1.0, 1.0)]
    return model_of(name, "rack", 505, (0.08, length, 0.1), fused([body, *ends]), turns=2)
