"""Selective pallet racking: upright frames and beams, in a few fixed sizes.

Frame of both: x along the aisle, y into the rack, z up, origin at the centre of the bounding box. A bay is 2.7 m clear
between uprights: three EPAL 1 pallets short side out with four gaps of 75 mm.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, solid_box
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.pose import rotation_x
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part

BAY_WIDTH = 2.7
"""Clear width between two frames (m)."""
FRAME_DEPTH = 1.1
"""Outer depth of a frame (m); a 1.2 m deep pallet overhangs it by 50 mm front and back."""
UPRIGHT_WIDTH, UPRIGHT_DEPTH = 0.10, 0.08
"""Outer section of an upright along x and y (m)."""
BEAM_HEIGHT, BEAM_DEPTH = 0.12, 0.05
"""Section of a beam along z and y (m)."""
CONNECTOR_HEIGHT = 0.19
"""Height of the plate at a beam's end, flush with the beam's top (m)."""

_SHEET = 0.004
_LIP = 0.022
_LACING_PITCH = 0.6
_FRAME_HEIGHTS_MM = (2000, 2500, 3500, 4500, 5500, 6500)

FRAME_HEIGHTS = {f"rack_frame_{mm}": mm / 1000 for mm in _FRAME_HEIGHTS_MM}
"""Catalog name -> height (m), lowest first."""


def rack_frame(name: str) -> ObjectModel:
    """Build an upright frame: two omega uprights on base plates, laced by horizontals and diagonals.

    Raises:
        UnknownNameError: No frame has this name; see ``FRAME_HEIGHTS``.
    """
    if name not in FRAME_HEIGHTS:
        raise UnknownNameError("rack frame", name, list(FRAME_HEIGHTS))
    height = FRAME_HEIGHTS[name]
    front, back = _upright(height, -1.0), _upright(height, 1.0)
    solid = [
        solid_box((UPRIGHT_WIDTH, UPRIGHT_DEPTH, height), (0.0, side * (FRAME_DEPTH - UPRIGHT_DEPTH) / 2, 0.0))
        for side in (-1.0, 1.0)
    ]
    lacing = _lacing(height)
    plates = _base_plates(height)
    return ObjectModel(
        name=name,
        class_name="rack",
        obj_id=101 + _FRAME_HEIGHTS_MM.index(round(1000 * height)),
        size=np.array([0.15, FRAME_DEPTH + 2 * 0.02, height]),
        parts=(*front, *back, *plates, *lacing),
        collision=(*solid, *collision_boxes(plates + lacing)),
    )


def rack_beam(name: str = "rack_beam_2700") -> ObjectModel:
    """Build the 2.7 m box beam with its end plates; z of the top is half the end plates' height."""
    top = CONNECTOR_HEIGHT / 2
    body = box_part((BAY_WIDTH, BEAM_DEPTH, BEAM_HEIGHT), (0.0, 0.0, top - BEAM_HEIGHT / 2), "rack_orange")
    lower = CONNECTOR_HEIGHT - BEAM_HEIGHT
    ends = [
        box_part((0.045, BEAM_DEPTH, lower), (side * (BAY_WIDTH - 0.045) / 2, 0.0, -top + lower / 2), "rack_orange")
        for side in (-1.0, 1.0)
    ]
    parts = (body, *ends)
    return ObjectModel(
        name=name,
        class_name="rack",
        obj_id=111,
        size=np.array([BAY_WIDTH, BEAM_DEPTH, CONNECTOR_HEIGHT]),
        parts=parts,
        collision=collision_boxes(parts),
        symmetry=SymmetryGroup.turns("z", 2),
    )


def _upright(height: float, side: float) -> list[Part]:
    """Return the web, flanges and lips of the upright at y = ``side`` * half the frame's depth; it opens inwards."""
    outer = side * FRAME_DEPTH / 2
    web = ((UPRIGHT_WIDTH, _SHEET, height), (0.0, outer - side * _SHEET / 2, 0.0))
    inner = outer - side * UPRIGHT_DEPTH
    pieces = [web]
    for turn in (-1.0, 1.0):
        x = turn * (UPRIGHT_WIDTH - _SHEET) / 2
        depth = UPRIGHT_DEPTH - _SHEET
        pieces.append(((_SHEET, depth, height), (x, inner + side * depth / 2, 0.0)))
        lip_x = turn * (UPRIGHT_WIDTH / 2 - _SHEET - _LIP / 2)
        pieces.append(((_LIP, _SHEET, height), (lip_x, inner + side * _SHEET / 2, 0.0)))
    return [box_part(size, centre, "rack_blue") for size, centre in pieces]


def _base_plates(height: float) -> list[Part]:
    """Return the two foot plates, 6 mm thick, that stand 20 mm out of the frame at front and back."""
    y = (FRAME_DEPTH - UPRIGHT_DEPTH) / 2
    size = (0.15, UPRIGHT_DEPTH + 0.04, 0.006)
    return [box_part(size, (0.0, side * y, -height / 2 + 0.003), "galvanised") for side in (-1.0, 1.0)]


def _lacing(height: float) -> list[Part]:
    """Return horizontals at both ends and diagonals in a zigzag between the uprights' inner faces."""
    span = FRAME_DEPTH - 2 * UPRIGHT_DEPTH
    low, high = -height / 2 + 0.15, height / 2 - 0.15
    bars = [box_part((0.03, span, 0.03), (0.0, 0.0, z), "galvanised") for z in (low, high)]
    count = max(1, round((high - low) / _LACING_PITCH))
    pitch = (high - low) / count
    # The bar's corners, not its axis, must stay between the uprights.
    length = np.hypot(span, pitch) - 0.03
    for index in range(count):
        rising = 1.0 if index % 2 == 0 else -1.0
        rotation = rotation_x(rising * np.arctan2(pitch, span))
        bars.append(box_part((0.025, length, 0.025), (0.0, 0.0, low + (index + 0.5) * pitch), "galvanised", rotation))
    return bars
