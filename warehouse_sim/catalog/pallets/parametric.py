"""Pallets that are in no catalog: any size, posts, feet and boards within what is built, with the pockets that follow.

Every site has some: one-way pallets, pallets of one trade or one supplier, each a few centimetres off the standards.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from warehouse_sim.catalog.pallets import Plan, block_pallet, built, plastic, stringer_pallet
from warehouse_sim.ranges import Range, check_ranges
from warehouse_sim.schema import ObjectModel

PalletKind = Literal["skids", "perimeter", "stringers", "notched_stringers", "runners", "feet"]
"""Nine blocks on three skids or on a frame, three stringers without or with notches; moulded: on runners or feet."""
_LEAST_WINDOW = 0.15
"""Forks are up to 0.15 m wide (ISO 2330)."""
_SQUEEZED = 0.92
_WOOD_DENSITY = 500.0
"""Of spruce at 20 % moisture (kg/m^3), about what UIC 435-2 pallets weigh by their volume."""


@dataclass(frozen=True)
class PalletShape:
    """What is free in the shape of a pallet; all lengths in m."""

    kind: PalletKind
    """How it is built."""
    length: Annotated[float, Range(0.5, 2.0, "m")]
    """Longer edge, 0.5-2."""
    width: Annotated[float, Range(0.4, 1.6, "m")]
    """Shorter edge, 0.4-1.6."""
    opening: Annotated[float, Range(0.06, 0.2, "m")]
    """Clear height for forks, 0.06-0.2."""
    board: Annotated[float, Range(0.01, 0.04, "m")]
    """Thickness of a board, or of a moulded deck, 0.01-0.04."""
    post: Annotated[float, Range(0.02, 0.25, "m")]
    """Width of the outer uprights, 0.02-0.25; narrower where no fork would fit between them."""
    middle_post: Annotated[float, Range(0.02, 0.25, "m")]
    """Width of the middle uprights, 0.02-0.25; narrower where no fork would fit between them."""
    boards: Annotated[int, Range(3, 15)]
    """Boards of a wooden deck, 3-15."""
    cover: Annotated[float, Range(0.3, 0.95)]
    """Fraction of a wooden deck that boards cover, 0.3-0.95."""
    lead: Annotated[float, Range(1.0, 2.0)]
    """Width of a wooden deck's first and last board over that of the others, 1-2."""
    deck_along: Literal["x", "y"]
    """Direction of a block pallet's deck boards; x runs along the longer edge."""

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.length < self.width:
            raise ValueError(f"length must not be below width, found {self.length} < {self.width}")


def parametric_pallet(name: str, obj_id: int, shape: PalletShape, material: str) -> ObjectModel:
    """Return the pallet of a shape; origin at the centre of its box, x along the longer edge, z up.

    Args:
        name: What it is called.
        obj_id: Number of its geometry.
        shape: Its sizes.
        material: What it is made of.
    """
    plan = _PLANS[shape.kind](obj_id, shape)
    model = built(name, plan, material, material)
    return replace(model, mass=_wooden_mass(model)) if plan.mass == 0.0 else model


def _block_plan(obj_id: int, shape: PalletShape) -> block_pallet.BlockPallet:
    along, across = shape.length, shape.width
    if shape.deck_along == "y":
        along, across = across, along
    posts = shape.post, shape.middle_post
    return block_pallet.BlockPallet(
        obj_id=obj_id,
        along=along,
        across=across,
        mass=0.0,
        deck=_deck(across, shape),
        lanes=_fitting(posts, across),
        columns=_fitting(posts, along),
        block=shape.opening,
        board=shape.board,
        base="perimeter" if shape.kind == "perimeter" else "skids",
        deck_along=shape.deck_along,
        make="",
    )


def _stringer_plan(obj_id: int, shape: PalletShape) -> stringer_pallet.StringerPallet:
    # A stringer is a plank on edge: a third of the width of a block.
    thick = shape.post / 3
    lead, inner = _deck(shape.length, shape)[:2]
    notch, from_end = None, 0.125 * shape.length
    if shape.kind == "notched_stringers":
        notch = (0.19 * shape.length, 0.4 * shape.opening)
        # Boards of the lower deck leave the notches open.
        lead, inner = min(lead, from_end), min(inner, 0.1 * shape.length)
    return stringer_pallet.StringerPallet(
        obj_id=obj_id,
        length=shape.length,
        width=shape.width,
        stringer=(thick, shape.opening),
        notch=notch,
        notch_from_end=from_end,
        board=shape.board,
        lead=lead,
        inner=inner,
        top_boards=shape.boards,
        mass=0.0,
    )


def _runner_plan(obj_id: int, shape: PalletShape) -> plastic.RunnerPallet:
    runner = 0.02
    return plastic.RunnerPallet(
        obj_id=obj_id,
        length=shape.length,
        width=shape.width,
        height=shape.board + shape.opening + runner,
        deck=shape.board,
        runner=runner,
        block=_fitting((shape.middle_post,) * 2, shape.length)[1],
        lanes=_fitting((shape.post, shape.middle_post), shape.width),
        mass=_moulded_mass(shape),
    )


def _foot_plan(obj_id: int, shape: PalletShape) -> plastic.FootPallet:
    # Feet narrow by a quarter towards the ground, as they must to nest.
    top = _fitting((shape.middle_post,) * 2, shape.length)[0], _fitting((shape.post,) * 2, shape.width)[0]
    return plastic.FootPallet(
        obj_id=obj_id,
        length=shape.length,
        width=shape.width,
        height=shape.board + shape.opening,
        deck=shape.board,
        foot_top=top,
        foot_bottom=(0.75 * top[0], 0.72 * top[1]),
        mass=0.4 * _moulded_mass(shape),
    )


def _deck(across: float, shape: PalletShape) -> tuple[float, ...]:
    """Return the widths of the deck boards (m), which cover their fraction of ``across``."""
    inner = shape.cover * across / (shape.boards - 2 + 2 * shape.lead)
    return (shape.lead * inner, *(inner,) * (shape.boards - 2), shape.lead * inner)


def _fitting(posts: tuple[float, float], length: float) -> tuple[float, float]:
    """Return the widths of outer and middle uprights (m) along ``length``, less where a window would be too narrow."""
    outer, middle = posts
    while (length - 2 * outer - middle) / 2 < _LEAST_WINDOW:
        outer, middle = _SQUEEZED * outer, _SQUEEZED * middle
    return outer, middle


def _wooden_mass(model: ObjectModel) -> float:
    """Return the mass (kg) of a pallet of softwood; its parts are solid."""
    volumes = [float(np.prod(np.ptp(part.placed().vertices, axis=0))) for part in model.parts]
    return _WOOD_DENSITY * sum(volumes)


def _moulded_mass(shape: PalletShape) -> float:
    """Return the mass (kg), in proportion to 18 kg of 1200 x 800 x 150 mm."""
    return 18.0 * shape.length * shape.width / 0.96 * (shape.opening + shape.board) / 0.13


_PLANS: dict[PalletKind, Callable[[int, PalletShape], Plan]] = {
    "skids": _block_plan,
    "perimeter": _block_plan,
    "stringers": _stringer_plan,
    "notched_stringers": _stringer_plan,
    "runners": _runner_plan,
    "feet": _foot_plan,
}
