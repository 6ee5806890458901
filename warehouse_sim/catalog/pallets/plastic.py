"""Moulded pallets, on three runners or on nine feet that nest, as plans of numbers; x along the longer edge.

Sizes of ``RUNNERS`` follow stand.no 141 ("Specification for reusable 1/1 plastic pallet"): at most 18 kg, 144-151 mm
high; 800 mm face: opening at least 90 mm high, middle block at most 150 mm, at least 595 mm between the outer blocks;
1200 mm face: opening 100-103 mm high, middle block at most 150 mm, at least 900 mm between the outer ones.

``FEET`` is a light one-way pallet as sold at 1200 x 800 x 140 mm and 6 kg (comansa, 045494) or 5.6 kg
(Goplasticpallets, APB1208 LSO). Its feet keep the same clear widths. Unverified: thickness of the deck, pitch of the
grid, taper of the feet.
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.pallets.moulded import Rectangle, grid_deck, nesting_foot, ribbed_block
from warehouse_sim.catalog.pallets.pockets import Window, pallet_model, window_between
from warehouse_sim.catalog.parts import box_part, in_role, mesh_part, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.schema import ObjectModel, Part

_HOLES, _RIB, _BORDER = (18, 12), 0.014, 0.024
_RIBS = (0.045, 0.009, 0.006)
_WALL, _FOOT_RADIUS = 0.004, 0.012


@dataclass(frozen=True)
class RunnerPallet:
    """The plan of a pallet on three runners; all lengths in m."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float = 1.2
    """Edge along x."""
    width: float = 0.8
    """Edge along y."""
    height: float = 0.150
    """Height over all."""
    deck: float = 0.030
    """Thickness of the deck."""
    runner: float = 0.020
    """Thickness of a runner."""
    block: float = 0.145
    """Length of the blocks along x."""
    lanes: tuple[float, float] = (0.100, 0.145)
    """Widths of the outer lanes of blocks and of the middle one."""
    mass: float = 18.0
    """Kilograms."""


@dataclass(frozen=True)
class FootPallet:
    """The plan of a pallet on nine nesting feet; all lengths in m."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float = 1.2
    """Edge along x."""
    width: float = 0.8
    """Edge along y."""
    height: float = 0.140
    """Height over all."""
    deck: float = 0.025
    """Thickness of the deck."""
    foot_top: tuple[float, float] = (0.140, 0.095)
    """Outer edges of a foot along x and y under the deck."""
    foot_bottom: tuple[float, float] = (0.105, 0.065)
    """Outer edges of a foot along x and y on the ground."""
    inset: float = 0.005
    """Distance of the outer feet from the pallet's sides."""
    mass: float = 6.0
    """Kilograms."""


RUNNERS, FEET = RunnerPallet(obj_id=8), FootPallet(obj_id=9)


def on_runners(plan: RunnerPallet, name: str, plastic: str) -> ObjectModel:
    """Return the pallet on three runners, of the material ``plastic``."""
    lanes = _lanes(plan)
    rows = [(x, y, width) for x in _middles(plan.length, plan.block) for y, width in lanes]
    above_blocks = tuple((x, y, plan.block, width) for x, y, width in rows)
    deck = grid_deck(plan.length, plan.width, plan.deck, _holes(plan), _RIB, _BORDER, solid=above_blocks)
    upright = plan.height - plan.deck - plan.runner
    block_z = plan.runner + (upright - plan.height) / 2
    deck_z, low = (plan.height - plan.deck) / 2, (plan.runner - plan.height) / 2
    parts = [mesh_part(deck, plastic, (0.0, 0.0, deck_z))]
    for x, y, width in rows:
        block = ribbed_block(plan.block, width, upright, *_RIBS)
        parts.append(mesh_part(block, plastic, (x, y, block_z)))
    parts += [box_part((plan.length, width, plan.runner), (0.0, y, low), plastic) for y, width in lanes]
    solids = [solid_box((plan.block, width, upright), (x, y, block_z)) for x, y, width in rows]
    solids += [solid_box((plan.length, width, plan.runner), (0.0, y, low)) for y, width in lanes]
    ends = window_between(*plan.lanes, plan.width, 0.0, plan.runner + upright)
    sides = window_between(plan.block, plan.block, plan.length, plan.runner, plan.runner + upright)
    return _moulded(name, plan, parts, solids, ends, sides)


def on_feet(plan: FootPallet, name: str, plastic: str) -> ObjectModel:
    """Return the pallet on nine nesting feet, of the material ``plastic``."""
    upright = plan.height - plan.deck
    (length, width), inset = plan.foot_top, plan.inset
    columns, lanes = _middles(plan.length - 2 * inset, length), _middles(plan.width - 2 * inset, width)
    places = [(x, y) for x in columns for y in lanes]
    mouths: tuple[Rectangle, ...] = tuple((x, y, length - 2 * _WALL, width - 2 * _WALL) for x, y in places)
    deck = grid_deck(plan.length, plan.width, plan.deck, _holes(plan), _RIB, _BORDER, open_=mouths)
    foot = nesting_foot(plan.foot_top, plan.foot_bottom, upright, _WALL, _FOOT_RADIUS)
    parts: list[Part] = [mesh_part(deck, plastic, (0.0, 0.0, (plan.height - plan.deck) / 2))]
    parts += [mesh_part(foot, plastic, (x, y, -plan.deck / 2)) for x, y in places]
    # The narrow end of a foot, so that no box is wider than the foot it stands for.
    solids: list[OrientedBox] = [solid_box((*plan.foot_bottom, upright), (x, y, -plan.deck / 2)) for x, y in places]
    ends = window_between(width + inset, width, plan.width, 0.0, upright)
    sides = window_between(length + inset, length, plan.length, 0.0, upright)
    return _moulded(name, plan, parts, solids, ends, sides)


def _moulded(
    name: str,
    plan: RunnerPallet | FootPallet,
    parts: list[Part],
    solids: list[OrientedBox],
    ends: Window,
    sides: Window,
) -> ObjectModel:
    """Return the pallet of these parts and uprights, with pockets on all sides."""
    plate = solid_box((plan.length, plan.width, plan.deck), (0.0, 0.0, (plan.height - plan.deck) / 2))
    size = np.array([plan.length, plan.width, plan.height])
    windows = {"-x": ends, "+x": ends, "-y": sides, "+y": sides}
    return pallet_model(name, plan.obj_id, plan.mass, size, in_role(parts, "moulded"), (plate, *solids), windows)


def _holes(plan: RunnerPallet | FootPallet) -> tuple[int, int]:
    """Return how many holes the deck has along x and y; their pitch is that of 18 x 12 on 1200 x 800 mm."""
    return round(_HOLES[0] * plan.length / 1.2), round(_HOLES[1] * plan.width / 0.8)


def _middles(length: float, outer: float) -> tuple[float, float, float]:
    """Return the centres of three rows of width ``outer`` (m): two flush with the ends of ``length``, one between."""
    edge = (length - outer) / 2
    return -edge, 0.0, edge


def _lanes(plan: RunnerPallet) -> list[tuple[float, float]]:
    """Return (y, width) of the three lanes of blocks."""
    outer, middle = plan.lanes
    return list(zip(_middles(plan.width, outer), (outer, middle, outer), strict=True))
