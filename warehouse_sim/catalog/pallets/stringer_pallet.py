"""The 48 x 40 inch pallet of the North American grocery trade: three notched stringers between two decks.

Pieces after oregonpallet.com ("GMA Pallet Specifications"): stringers of 1 3/8 x 3 1/2 x 48 in; boards of 5/8 in; on
top two of 5 1/2 in and five of 3 1/2 in, at the bottom two of 5 1/2 in at the ends and three of 3 1/2 in between the
notches. Two notches of 9 x 1 1/2 in, 18 in apart, open each stringer from below (nationwidepalletandcrate.com), which
puts them 6 in from its ends. Derived: height 4 3/4 in. Unverified: mass.

Forks enter the 40 inch faces between the stringers and the 48 inch faces, low down, through the notches. Frame: x along
the stringers, y along the boards.
"""

import numpy as np

from warehouse_sim.catalog.pallets.pockets import Window, pockets_behind, window_between
from warehouse_sim.catalog.parts import box_part, collision_boxes, in_role, solid_box, solid_part
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.solids import Outline, prism
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part

_INCH = 0.0254
LENGTH, WIDTH, HEIGHT = 48 * _INCH, 40 * _INCH, 4.75 * _INCH
"""Outer edges (m)."""
STRINGER_WIDTH, STRINGER_HEIGHT = 1.375 * _INCH, 3.5 * _INCH
"""Section of a stringer (m)."""
NOTCH_LENGTH, NOTCH_HEIGHT, NOTCH_FROM_END = 9 * _INCH, 1.5 * _INCH, 6 * _INCH
"""Size of a notch and its distance from the stringer's end (m)."""
BOARD, LEAD, INNER = 0.625 * _INCH, 5.5 * _INCH, 3.5 * _INCH
"""Thickness of a board; widths of the boards at the ends and of the others (m)."""

_MIDDLE = LENGTH - 2 * (NOTCH_FROM_END + NOTCH_LENGTH)
# A prism's outline lies in its own xy plane; on edge, its y is up and its extrusion runs along the object's -y.
_ON_EDGE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def build(name: str, board: str, stringer: str) -> ObjectModel:
    """Return the pallet with boards and stringers of the given materials."""
    top, bottom = _boards(_top_layout(), HEIGHT - BOARD, board), _boards(_bottom_layout(), 0.0, board)
    beam = prism(_notched_outline(), STRINGER_WIDTH)
    stringers = [solid_part(beam, (1.0, 1.0, 1.0), (0.0, y, 0.0), stringer, _ON_EDGE) for y in _stringer_rows()]
    plate = solid_box((LENGTH, WIDTH, BOARD), (0.0, 0.0, (HEIGHT - BOARD) / 2))
    size = np.array([LENGTH, WIDTH, HEIGHT])
    return ObjectModel(
        name=name,
        class_name="pallet",
        obj_id=6,
        size=size,
        parts=(*in_role(top, "deck"), *in_role(stringers, "stringer"), *in_role(bottom, "base")),
        collision=(plate, *_stringer_solids(), *collision_boxes(bottom)),
        mass=18.0,
        symmetry=SymmetryGroup.turns("z", 2),
        pockets=pockets_behind(_windows(), size),
    )


def _stringer_rows() -> tuple[float, float, float]:
    edge = (WIDTH - STRINGER_WIDTH) / 2
    return -edge, 0.0, edge


def _top_layout() -> list[tuple[float, float]]:
    """Return (x, width) of the seven top boards with equal gaps."""
    widths = (LEAD, *(INNER,) * 5, LEAD)
    gap = (LENGTH - sum(widths)) / 6
    starts = np.cumsum([0.0, *(width + gap for width in widths[:-1])]) - LENGTH / 2
    return [(float(start) + width / 2, width) for start, width in zip(starts, widths, strict=True)]


def _bottom_layout() -> list[tuple[float, float]]:
    """Return (x, width) of the five bottom boards: flush with the ends, and with the notches' inner sides."""
    lead, inner = (LENGTH - LEAD) / 2, (_MIDDLE - INNER) / 2
    return [(-lead, LEAD), (-inner, INNER), (0.0, INNER), (inner, INNER), (lead, LEAD)]


def _boards(layout: list[tuple[float, float]], bottom: float, material: str) -> list[Part]:
    z = bottom + (BOARD - HEIGHT) / 2
    return [box_part((width, WIDTH, BOARD), (x, 0.0, z), material) for x, width in layout]


def _notched_outline() -> Outline:
    """Return the stringer seen from its side, counter-clockwise, centred on its bounding box."""
    half, low, high = LENGTH / 2, -STRINGER_HEIGHT / 2, STRINGER_HEIGHT / 2
    roof, outer, inner = low + NOTCH_HEIGHT, half - NOTCH_FROM_END, _MIDDLE / 2
    right = [(inner, low), (inner, roof), (outer, roof), (outer, low), (half, low), (half, high)]
    left = [(-x, y) for x, y in reversed(right)]
    return (*right, *left)


def _stringer_solids() -> list[OrientedBox]:
    """Return four boxes for each stringer: what is above the notches, and three feet."""
    beam = STRINGER_HEIGHT - NOTCH_HEIGHT
    boxes = []
    for y in _stringer_rows():
        boxes.append(solid_box((LENGTH, STRINGER_WIDTH, beam), (0.0, y, NOTCH_HEIGHT / 2)))
        end = (LENGTH - NOTCH_FROM_END) / 2
        for x, length in ((-end, NOTCH_FROM_END), (0.0, _MIDDLE), (end, NOTCH_FROM_END)):
            boxes.append(solid_box((length, STRINGER_WIDTH, NOTCH_HEIGHT), (x, y, -beam / 2)))
    return boxes


def _windows() -> dict[str, Window]:
    ends = window_between(STRINGER_WIDTH, STRINGER_WIDTH, WIDTH, BOARD, HEIGHT - BOARD)
    notch = Window(NOTCH_LENGTH, (_MIDDLE + NOTCH_LENGTH) / 2, 0.0, BOARD + NOTCH_HEIGHT)
    return {"-x": ends, "+x": ends, "-y": notch, "+y": notch}
