"""Two moulded pallets of 1200 x 800 mm, one on three runners, one on nine feet that nest; x along 1200, y along 800.

Sizes of the first follow stand.no 141 ("Specification for reusable 1/1 plastic pallet"): at most 18 kg, 144-151 mm
high; 800 mm face: opening at least 90 mm high, middle block at most 150 mm, at least 595 mm between the outer blocks;
1200 mm face: opening 100-103 mm high, middle block at most 150 mm, at least 900 mm between the outer ones.

The second is a light one-way pallet as sold at 1200 x 800 x 140 mm and 6 kg (comansa, 045494) or 5.6 kg
(Goplasticpallets, APB1208 LSO). Its feet keep the same clear widths. Unverified: thickness of the deck, pitch of the
grid, taper of the feet.
"""

import numpy as np

from warehouse_sim.catalog.pallets.moulded import Rectangle, grid_deck, nesting_foot, ribbed_block
from warehouse_sim.catalog.pallets.pockets import pockets_behind, window_between
from warehouse_sim.catalog.parts import box_part, in_role, solid_box, solid_part
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part

LENGTH, WIDTH = 1.2, 0.8
"""Outer edges (m)."""

_ONE = (1.0, 1.0, 1.0)
_HOLES, _RIB, _BORDER = (18, 12), 0.014, 0.024

RUNNER_HEIGHT, RUNNER_DECK, RUNNER = 0.150, 0.030, 0.020
"""Height of the pallet on runners, of its deck and of a runner (m)."""
BLOCK_LENGTH, LANES = 0.145, (0.100, 0.145, 0.100)
"""Length of its blocks along x, and the widths of its three lanes of blocks (m)."""
_RIBS = (0.045, 0.009, 0.006)

NEST_HEIGHT, NEST_DECK = 0.140, 0.025
"""Height of the pallet on feet and of its deck (m)."""
FOOT_TOP, FOOT_BOTTOM, FOOT_INSET = (0.140, 0.095), (0.105, 0.065), 0.005
"""Outer edges of a foot under the deck and on the ground, and its distance from the pallet's side (m)."""
_WALL, _FOOT_RADIUS = 0.004, 0.012


def on_runners(name: str, plastic: str) -> ObjectModel:
    """Return the pallet on three runners, of the material ``plastic``."""
    rows = [(x, y, width) for x in _middles(LENGTH, BLOCK_LENGTH) for y, width in _lanes()]
    above_blocks = tuple((x, y, BLOCK_LENGTH, width) for x, y, width in rows)
    deck = grid_deck(LENGTH, WIDTH, RUNNER_DECK, _HOLES, _RIB, _BORDER, solid=above_blocks)
    upright = RUNNER_HEIGHT - RUNNER_DECK - RUNNER
    block_z = RUNNER + (upright - RUNNER_HEIGHT) / 2
    parts = [solid_part(deck, _ONE, (0.0, 0.0, (RUNNER_HEIGHT - RUNNER_DECK) / 2), plastic)]
    for x, y, width in rows:
        block = ribbed_block(BLOCK_LENGTH, width, upright, *_RIBS)
        parts.append(solid_part(block, _ONE, (x, y, block_z), plastic))
    low = (RUNNER - RUNNER_HEIGHT) / 2
    parts += [box_part((LENGTH, width, RUNNER), (0.0, y, low), plastic) for y, width in _lanes()]
    solids = [solid_box((BLOCK_LENGTH, width, upright), (x, y, block_z)) for x, y, width in rows]
    solids += [solid_box((LENGTH, width, RUNNER), (0.0, y, low)) for y, width in _lanes()]
    ends = window_between(LANES[0], LANES[1], WIDTH, 0.0, RUNNER + upright)
    sides = window_between(BLOCK_LENGTH, BLOCK_LENGTH, LENGTH, RUNNER, RUNNER + upright)
    windows = {"-x": ends, "+x": ends, "-y": sides, "+y": sides}
    plate = solid_box((LENGTH, WIDTH, RUNNER_DECK), (0.0, 0.0, (RUNNER_HEIGHT - RUNNER_DECK) / 2))
    size = np.array([LENGTH, WIDTH, RUNNER_HEIGHT])
    return ObjectModel(
        name,
        "pallet",
        8,
        size,
        tuple(in_role(parts, "moulded")),
        (plate, *solids),
        18.0,
        _half_turn(),
        pockets_behind(windows, size),
    )


def on_feet(name: str, plastic: str) -> ObjectModel:
    """Return the pallet on nine nesting feet, of the material ``plastic``."""
    upright = NEST_HEIGHT - NEST_DECK
    (length, width), inset = FOOT_TOP, FOOT_INSET
    columns, lanes = _middles(LENGTH - 2 * inset, length), _middles(WIDTH - 2 * inset, width)
    places = [(x, y) for x in columns for y in lanes]
    mouths: tuple[Rectangle, ...] = tuple((x, y, length - 2 * _WALL, width - 2 * _WALL) for x, y in places)
    deck = grid_deck(LENGTH, WIDTH, NEST_DECK, _HOLES, _RIB, _BORDER, open_=mouths)
    foot = nesting_foot(FOOT_TOP, FOOT_BOTTOM, upright, _WALL, _FOOT_RADIUS)
    parts: list[Part] = [solid_part(deck, _ONE, (0.0, 0.0, (NEST_HEIGHT - NEST_DECK) / 2), plastic)]
    parts += [solid_part(foot, _ONE, (x, y, -NEST_DECK / 2), plastic) for x, y in places]
    # The narrow end of a foot, so that no box is wider than the foot it stands for.
    solids: list[OrientedBox] = [solid_box((*FOOT_BOTTOM, upright), (x, y, -NEST_DECK / 2)) for x, y in places]
    plate = solid_box((LENGTH, WIDTH, NEST_DECK), (0.0, 0.0, (NEST_HEIGHT - NEST_DECK) / 2))
    ends = window_between(width + inset, width, WIDTH, 0.0, upright)
    sides = window_between(length + inset, length, LENGTH, 0.0, upright)
    windows = {"-x": ends, "+x": ends, "-y": sides, "+y": sides}
    size = np.array([LENGTH, WIDTH, NEST_HEIGHT])
    return ObjectModel(
        name,
        "pallet",
        9,
        size,
        tuple(in_role(parts, "moulded")),
        (plate, *solids),
        6.0,
        _half_turn(),
        pockets_behind(windows, size),
    )


def _half_turn() -> SymmetryGroup:
    return SymmetryGroup.turns("z", 2)


def _middles(length: float, outer: float) -> tuple[float, float, float]:
    """Return the centres of three rows of width ``outer`` (m): two flush with the ends of ``length``, one between."""
    edge = (length - outer) / 2
    return -edge, 0.0, edge


def _lanes() -> list[tuple[float, float]]:
    """Return (y, width) of the three lanes of blocks."""
    return list(zip(_middles(WIDTH, LANES[0]), LANES, strict=True))
