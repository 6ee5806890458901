"""Pallets on three by three uprights, board by board: a plan of numbers and the pieces that follow from it.

Everything is laid out in the plan's own directions: *along* the deck boards, and *across* them, along the three
stringer boards that carry the deck. Three *columns* of uprights stand under the stringer boards, three *lanes* run
along the deck. From the top: deck boards, stringer boards, uprights, and the base on the ground.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.pallets.pockets import Window, pallet_model, window_between
from warehouse_sim.catalog.parts import box_part, collision_boxes, in_role, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.schema import ObjectModel, Part

_STEEL = 0.003


@dataclass(frozen=True)
class BlockPallet:
    """The plan of a pallet; all lengths in m."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    along: float
    """Length of a deck board."""
    across: float
    """Length of a stringer board."""
    mass: float
    """Kilograms."""
    deck: tuple[float, ...]
    """Widths of the deck boards in order; they share what is left of ``across`` as equal gaps."""
    lanes: tuple[float, float]
    """Width across of the uprights in the outer lanes and in the middle lane."""
    columns: tuple[float, float]
    """Length along of the uprights in the outer columns and in the middle column."""
    block: float
    """Height of an upright."""
    board: float = 0.022
    """Thickness of every board."""
    base: Literal["skids", "perimeter"] = "skids"
    """Three boards along the lanes, or a frame on the ground with one more board across in its middle."""
    base_widths: tuple[float, float] | None = None
    """Width of the boards along the outer lanes and the middle lane; that of the uprights by default."""
    stringer_widths: tuple[float, float] | None = None
    """Width of the outer stringer boards and the middle one; that of the uprights by default."""
    brackets: bool = False
    """Whether steel brackets instead of wooden blocks stand in the rows along the pallet's longer edges."""
    deck_along: Literal["x", "y"] = "x"
    """Direction of the deck boards in the object frame, whose x runs along the longer edge."""

    @property
    def height(self) -> float:
        """Height over all (m)."""
        return round(3 * self.board + self.block, 6)

    make: str = "EPAL"
    """Whose mark it bears."""

    @property
    def size(self) -> Float[np.ndarray, " 3"]:
        """Outer edge lengths (m)."""
        edges = (self.along, self.across) if self.deck_along == "x" else (self.across, self.along)
        return np.array([*edges, self.height])

    @property
    def block_top(self) -> float:
        """Height of the uprights' upper ends above the ground (m)."""
        return self.board + self.block

    @property
    def deck_bottom(self) -> float:
        """Height of the deck boards' underside above the ground (m)."""
        return self.block_top + self.board


def build(plan: BlockPallet, name: str, board: str, block: str) -> ObjectModel:
    """Return the pallet of ``plan``.

    Args:
        plan: What to build.
        name: Catalog name.
        board: Material of the boards.
        block: Material of the wooden blocks.
    """
    deck, blocks = in_role(_deck_boards(plan, board), "deck"), in_role(_wooden_blocks(plan, block), "block")
    cross, base = in_role(_stringer_boards(plan, board), "cross"), in_role(_base_boards(plan, board), "base")
    frame = [*cross, *blocks, *base]
    # Physics sees the deck as one plate: nothing that stands on it is small enough to feel the gaps.
    x, y, height = (float(edge) for edge in plan.size)
    plate = solid_box((x, y, plan.board), (0.0, 0.0, (plan.deck_bottom + height) / 2.0 - height / 2.0))
    parts = (*deck, *frame, *in_role(_brackets(plan), "bracket"))
    solids = (plate, *collision_boxes(frame), *_bracket_solids(plan))
    return pallet_model(name, plan.obj_id, plan.mass, plan.size, parts, solids, _windows(plan), plan.make)


def _deck_boards(plan: BlockPallet, material: str) -> list[Part]:
    gap = (plan.across - sum(plan.deck)) / (len(plan.deck) - 1)
    starts = np.cumsum([0.0, *(width + gap for width in plan.deck[:-1])]) - plan.across / 2.0
    return [
        _piece(
            plan, (plan.along, width, plan.board), (0.0, start + width / 2.0), (plan.deck_bottom, plan.height), material
        )
        for start, width in zip(starts, plan.deck, strict=True)
    ]


def _stringer_boards(plan: BlockPallet, material: str) -> list[Part]:
    return [
        _piece(plan, (width, plan.across, plan.board), (centre, 0.0), (plan.block_top, plan.deck_bottom), material)
        for centre, width in _rows(plan.along, plan.stringer_widths or plan.columns)
    ]


def _wooden_blocks(plan: BlockPallet, material: str) -> list[Part]:
    return [
        _piece(plan, (length, width, plan.block), (u, v), (plan.board, plan.block_top), material)
        for u, length in _rows(plan.along, plan.columns)
        for v, width in _rows(plan.across, plan.lanes)
        if not _is_bracket(plan, u, v)
    ]


def _base_boards(plan: BlockPallet, material: str) -> list[Part]:
    level = (0.0, plan.board)
    lanes = _rows(plan.across, plan.base_widths or plan.lanes)
    if plan.base == "skids":
        return [_piece(plan, (plan.along, width, plan.board), (0.0, v), level, material) for v, width in lanes]
    # The frame lies in one plane: two boards at the ends, three between them.
    ends = [
        _piece(plan, (plan.along, width, plan.board), (0.0, v), level, material) for v, width in (lanes[0], lanes[2])
    ]
    length = plan.across - 2 * lanes[0][1]
    rows = _rows(plan.along, plan.columns)
    return [*ends, *(_piece(plan, (width, length, plan.board), (u, 0.0), level, material) for u, width in rows)]


def _brackets(plan: BlockPallet) -> list[Part]:
    """Return three 3 mm plates for each bracket: one upright in the pallet's side, two webs behind its ends."""
    parts = []
    for box in _bracket_solids(plan):
        (x, y, z), (length, depth, height) = box.T_parent_box[:3, 3], box.size
        side = float(np.sign(y))
        parts.append(box_part((length, _STEEL, height), (x, y + side * (depth - _STEEL) / 2, z), "galvanised"))
        for end in (-1.0, 1.0):
            centre = (x + end * (length - _STEEL) / 2, y - side * _STEEL / 2, z)
            parts.append(box_part((_STEEL, depth - _STEEL, height), centre, "galvanised"))
    return parts


def _bracket_solids(plan: BlockPallet) -> list[OrientedBox]:
    z = (plan.board + plan.block_top - plan.height) / 2.0
    return [
        solid_box(*_placed(plan, (length, width, plan.block), (u, v, z)))
        for u, length in _rows(plan.along, plan.columns)
        for v, width in _rows(plan.across, plan.lanes)
        if _is_bracket(plan, u, v)
    ]


def _is_bracket(plan: BlockPallet, u: float, v: float) -> bool:
    return plan.brackets and (v if plan.deck_along == "x" else u) != 0.0


def _windows(plan: BlockPallet) -> dict[str, Window]:
    """Return the windows of the four faces: as high as the boards that cross them leave room."""
    lane, column = plan.lanes, plan.columns
    skid, stringer = plan.base_widths or lane, plan.stringer_widths or column
    on_ground = plan.base == "skids" and skid[0] <= lane[0] and skid[1] <= lane[1]
    up_to_deck = stringer[0] <= column[0] and stringer[1] <= column[1]
    ends = window_between(*lane, plan.across, 0.0 if on_ground else plan.board, plan.block_top)
    sides = window_between(*column, plan.along, plan.board, plan.deck_bottom if up_to_deck else plan.block_top)
    by_direction = {plan.deck_along: ends, "y" if plan.deck_along == "x" else "x": sides}
    return {face: by_direction[face[1]] for face in ("-x", "+x", "-y", "+y")}


def _rows(length: float, widths: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    """Return (centre, width) of three rows: two flush with the ends of ``length`` and one in the middle."""
    outer, middle = widths
    edge = (length - outer) / 2.0
    return (-edge, outer), (0.0, middle), (edge, outer)


def _piece(
    plan: BlockPallet,
    size: tuple[float, float, float],
    centre: tuple[float, float],
    heights: tuple[float, float],
    material: str,
) -> Part:
    """Return a box by size (along, across, up), centre (along, across) and the two levels it lies between (m)."""
    z = sum(heights) / 2.0 - plan.height / 2.0
    return box_part(*_placed(plan, size, (*centre, z)), material)


def _placed(
    plan: BlockPallet, size: tuple[float, float, float], centre: tuple[float, float, float]
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Turn size and centre from (along, across, up) to the object frame."""
    if plan.deck_along == "x":
        return size, centre
    return (size[1], size[0], size[2]), (centre[1], centre[0], centre[2])
