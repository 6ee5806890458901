"""Pallets of three stringers between two decks, as plans: the 48 x 40 inch one of the North American grocery trade.

Pieces after oregonpallet.com ("GMA Pallet Specifications"): stringers of 1 3/8 x 3 1/2 x 48 in; boards of 5/8 in, on
top two of 5 1/2 in and five of 3 1/2 in, at the bottom two of 5 1/2 in at the ends and three of 3 1/2 in between the
notches. Two notches of 9 x 1 1/2 in, 18 in apart, open each stringer from below (nationwidepalletandcrate.com), which
puts them 6 in from its ends. Derived: height 4 3/4 in. Unverified: mass.

Forks enter the 40 inch faces between the stringers and the 48 inch faces, low down, through the notches. Frame: x along
the stringers, y along the boards.
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.pallets.pockets import Window, pallet_model, window_between
from warehouse_sim.catalog.parts import box_part, collision_boxes, in_role, mesh_part, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.solids import Outline, prism
from warehouse_sim.schema import ObjectModel, Part

_INCH = 0.0254
# A prism's outline lies in its own xy plane; on edge, its y is up and its extrusion runs along the object's -y.
_ON_EDGE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class StringerPallet:
    """The plan of a pallet; all lengths in m."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float = 48 * _INCH
    """Edge along x, that of a stringer."""
    width: float = 40 * _INCH
    """Edge along y, that of a board."""
    stringer: tuple[float, float] = (1.375 * _INCH, 3.5 * _INCH)
    """Width and height of a stringer."""
    notch: tuple[float, float] | None = (9 * _INCH, 1.5 * _INCH)
    """Length and height of its two notches; without, forks enter from the ends only."""
    notch_from_end: float = 6 * _INCH
    """From a stringer's end to its notch."""
    board: float = 0.625 * _INCH
    """Thickness of a board."""
    lead: float = 5.5 * _INCH
    """Width of the boards at the ends."""
    inner: float = 3.5 * _INCH
    """Width of the other boards."""
    top_boards: int = 7
    """Boards of the upper deck."""
    mass: float = 18.0
    """Kilograms."""

    @property
    def height(self) -> float:
        """Height over all (m)."""
        return self.stringer[1] + 2 * self.board

    @property
    def middle(self) -> float:
        """Length of a stringer between its notches (m)."""
        return self.length - 2 * (self.notch_from_end + (self.notch or (0.0, 0.0))[0])


GMA = StringerPallet(obj_id=6)


def build(plan: StringerPallet, name: str, board: str, stringer: str) -> ObjectModel:
    """Return the pallet of ``plan`` with boards and stringers of the given materials."""
    top = _boards(plan, _top_layout(plan), plan.height - plan.board, board)
    bottom = _boards(plan, _bottom_layout(plan), 0.0, board)
    beam = prism(_outline(plan), plan.stringer[0])
    stringers = [mesh_part(beam, stringer, (0.0, y, 0.0), _ON_EDGE) for y in _stringer_rows(plan)]
    plate = solid_box((plan.length, plan.width, plan.board), (0.0, 0.0, (plan.height - plan.board) / 2))
    size = np.array([plan.length, plan.width, plan.height])
    parts = (*in_role(top, "deck"), *in_role(stringers, "stringer"), *in_role(bottom, "base"))
    solids = (plate, *_stringer_solids(plan), *collision_boxes(bottom))
    return pallet_model(name, plan.obj_id, plan.mass, size, parts, solids, _windows(plan))


def _stringer_rows(plan: StringerPallet) -> tuple[float, float, float]:
    edge = (plan.width - plan.stringer[0]) / 2
    return -edge, 0.0, edge


def _top_layout(plan: StringerPallet) -> list[tuple[float, float]]:
    """Return (x, width) of the top boards with equal gaps."""
    widths = (plan.lead, *(plan.inner,) * (plan.top_boards - 2), plan.lead)
    gap = (plan.length - sum(widths)) / (plan.top_boards - 1)
    starts = np.cumsum([0.0, *(width + gap for width in widths[:-1])]) - plan.length / 2
    return [(float(start) + width / 2, width) for start, width in zip(starts, widths, strict=True)]


def _bottom_layout(plan: StringerPallet) -> list[tuple[float, float]]:
    """Return (x, width) of the five bottom boards: flush with the ends, and with the notches' inner sides."""
    lead, inner = (plan.length - plan.lead) / 2, (plan.middle - plan.inner) / 2
    return [(-lead, plan.lead), (-inner, plan.inner), (0.0, plan.inner), (inner, plan.inner), (lead, plan.lead)]


def _boards(plan: StringerPallet, layout: list[tuple[float, float]], bottom: float, material: str) -> list[Part]:
    z = bottom + (plan.board - plan.height) / 2
    return [box_part((width, plan.width, plan.board), (x, 0.0, z), material) for x, width in layout]


def _outline(plan: StringerPallet) -> Outline:
    """Return the stringer seen from its side, counter-clockwise, centred on its bounding box."""
    half, high = plan.length / 2, plan.stringer[1] / 2
    if plan.notch is None:
        return (-half, -high), (half, -high), (half, high), (-half, high)
    roof, outer, inner = plan.notch[1] - high, half - plan.notch_from_end, plan.middle / 2
    right = [(inner, -high), (inner, roof), (outer, roof), (outer, -high), (half, -high), (half, high)]
    left = [(-x, y) for x, y in reversed(right)]
    return (*right, *left)


def _stringer_solids(plan: StringerPallet) -> list[OrientedBox]:
    """Return the boxes of each stringer: one, or what is above its notches and three feet."""
    (thick, tall), boxes = plan.stringer, list[OrientedBox]()
    for y in _stringer_rows(plan):
        if plan.notch is None:
            boxes.append(solid_box((plan.length, thick, tall), (0.0, y, 0.0)))
            continue
        beam, end = tall - plan.notch[1], (plan.length - plan.notch_from_end) / 2
        boxes.append(solid_box((plan.length, thick, beam), (0.0, y, plan.notch[1] / 2)))
        for x, length in ((-end, plan.notch_from_end), (0.0, plan.middle), (end, plan.notch_from_end)):
            boxes.append(solid_box((length, thick, plan.notch[1]), (x, y, -beam / 2)))
    return boxes


def _windows(plan: StringerPallet) -> dict[str, Window]:
    ends = window_between(plan.stringer[0], plan.stringer[0], plan.width, plan.board, plan.height - plan.board)
    if plan.notch is None:
        return {"-x": ends, "+x": ends}
    notch = Window(plan.notch[0], (plan.middle + plan.notch[0]) / 2, 0.0, plan.board + plan.notch[1])
    return {"-x": ends, "+x": ends, "-y": notch, "+y": notch}
