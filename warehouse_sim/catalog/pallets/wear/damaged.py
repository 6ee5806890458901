"""Damaged pallets: other boards and look; frame, pockets, size, symmetry and collision stay.

Boards age in colour; nail heads, stains and bare patches are thin solids that lie on them.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from warehouse_sim.catalog.pallets.wear.brands import branded
from warehouse_sim.catalog.pallets.wear.damage import (
    Member,
    members_of,
    with_broken,
    with_displaced,
    with_twisted,
    without_missing,
)
from warehouse_sim.catalog.parts import mesh_part, solid_part
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.pose import rotation_z
from warehouse_sim.geometry.solids import prism, unit_cylinder
from warehouse_sim.ranges import Fraction, check_ranges
from warehouse_sim.schema import ObjectModel, Part
from warehouse_sim.schema.things import SAME_SHAPE

PAINTED = ("pallet_blue", "pallet_blue_worn")
"""Paint on wood from new to old."""
STAGES = (
    ("pallet_wood_new", "pallet_wood", "pallet_wood_tan", "pallet_wood_grey", "pallet_wood_dark"),
    ("pallet_block_new", "pallet_block", "pallet_block_grey"),
    PAINTED,
    ("plastic_grey", "plastic_grey_dusty"),
    ("plastic_black", "plastic_black_dusty"),
    ("plastic_blue", "plastic_blue_dusty"),
)
"""Materials from new to old, one line a kind of surface."""

_REPLACED = ("deck", "base", "cross", "block")
"""Roles of the pieces that a repair puts new ones in place of."""
_REPAIRED_FRACTION = 0.12
_UNEVENNESS = 0.22


def aged(members: list[Member], age: float, rng: np.random.Generator) -> list[Member]:
    """Return the members with older materials.

    Args:
        members: Pieces of the pallet.
        age: 0 keeps every material, 1 brings it to the last stage; pieces differ, and some have been replaced.
        rng: Stream to draw from.
    """

    def chance() -> tuple[float, bool]:
        """Return how unevenly one piece ages and whether it was replaced."""
        return rng.normal(0.0, _UNEVENNESS), bool(rng.random() < _REPAIRED_FRACTION * age)

    moulded = chance()  # what is moulded in one piece ages as one
    return [_older(member, age, *(moulded if member.role == "moulded" else chance())) for member in members]


def _older(member: Member, age: float, unevenness: float, replaced: bool) -> Member:
    stages = next((line for line in STAGES if member.body.material in line), ())
    if not stages:
        return member
    first, last = stages.index(member.body.material), len(stages) - 1
    fraction = np.clip(age + unevenness * np.sqrt(age), 0.0, 1.0) ** 1.2
    is_new = replaced and member.role in _REPLACED
    stage = 0 if is_new else first + int(np.round(fraction * (last - first)))
    body = replace(member.body, material=stages[stage])
    return replace(member, body=body, parts=(body,))


NAIL_HEAD = 0.009
"""Diameter of a nail's head (m)."""
SKIN = 0.0003
"""How far nails and stains stand proud of the wood (m); what lies on the deck swallows it."""

_BLOTS = 6
_NAIL_INSET = 0.028
_SAME = 1e-6


def nailed(members: list[Member]) -> list[Member]:
    """Return the members with nail heads on the deck, two where a deck board crosses what carries it."""
    return [_nailed(member, members) if member.role == "deck" else member for member in members]


def stained(members: list[Member], fraction: float, rng: np.random.Generator) -> list[Member]:
    """Return the members with oil and water stains, on each deck board with probability ``fraction``."""
    return [
        _stained(member, rng) if member.role == "deck" and rng.random() < fraction else member for member in members
    ]


def _nailed(board: Member, members: list[Member]) -> Member:
    carriers = {
        round(float(member.centre[board.axis]), 6) for member in members if member.role in ("cross", "stringer")
    }
    half, side = board.along("size") / 2 - NAIL_HEAD, board.aside("size") / 2 - _NAIL_INSET
    # Carriers at the ends are as wide as a board; the nails go through their middles.
    places = [place - board.along("centre") for place in sorted(carriers)]
    places = [place for place in places if abs(place) < half]
    if not places:
        return board
    heads = nail_heads(tuple((round(place, 6), sign * round(side, 6)) for place in places for sign in (-1.0, 1.0)))
    turn = np.eye(3) if board.axis == 0 else rotation_z(np.pi / 2)
    return board.with_parts(mesh_part(heads, "nail_steel", _on_top(board), turn))


@cache
def nail_heads(places: tuple[tuple[float, float], ...]) -> TriangleMesh:
    """Return flat round heads at ``places`` (x, y in m), half sunk into the plane z = 0."""
    head = unit_cylinder(8)
    size = np.array([NAIL_HEAD, NAIL_HEAD, 2 * SKIN])
    return merge([TriangleMesh(head.vertices * size + [x, y, 0.0], head.faces) for x, y in places])


def _stained(board: Member, rng: np.random.Generator) -> Member:
    parts: list[Part] = []
    # From painted boards the paint comes off; on bare ones oil and water stay.
    material = "pallet_wood_tan" if board.body.material in PAINTED else "wood_stain"
    for _ in range(int(rng.integers(1, 5))):
        width = board.aside("size") * (0.08 + 0.85 * rng.random() ** 2)
        length = min(width * rng.uniform(1.0, 4.0), 0.9 * board.along("size"))
        centre = np.array(_on_top(board))
        centre[board.axis] += rng.uniform(-0.5, 0.5) * (board.along("size") - length)
        centre[1 - board.axis] += rng.uniform(-0.5, 0.5) * (board.aside("size") - width)
        turn = rotation_z(np.pi / 2 * (board.axis + 2 * int(rng.integers(2))))
        blot = stain_shape(int(rng.integers(_BLOTS)))
        parts.append(solid_part(blot, (length, width, 2 * SKIN), tuple(centre), material, turn))
    return board.with_parts(*parts)


@cache
def stain_shape(number: int) -> TriangleMesh:
    """Return one of six blots that fill the cube of edge 1 m."""
    rng = np.random.default_rng([2026, 6, number])
    count = 48
    angles = np.arange(count) * (2 * np.pi / count)
    waves = sum(rng.normal(0.0, 0.5 / k) * np.cos(k * angles + rng.uniform(0.0, 2 * np.pi)) for k in range(2, 10))
    radius = np.clip(1.0 + waves, 0.35, 1.9)
    outline = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    low, high = outline.min(axis=0), outline.max(axis=0)
    outline = (outline - (low + high) / 2) / (high - low)
    return prism(tuple((float(x), float(y)) for x, y in outline))


def _on_top(board: Member) -> tuple[float, float, float]:
    """Return the middle of the board's upper face (m)."""
    x, y, z = (float(value) for value in board.centre)
    return x, y, z + float(board.body.scale[2]) / 2


@dataclass(frozen=True)
class WearConfig:
    """How much a pallet has been through; boards, blocks and marks are what wooden pallets have."""

    age: Fraction = 0.0
    """How weathered it looks, 0-1: 0 keeps its materials, 1 makes it grey and dark, or dusty if it is plastic."""
    missing: Fraction = 0.0
    """Fraction of the boards that can be missing and are, 0-1: inner deck boards whose gap no carton falls into."""
    broken: Fraction = 0.0
    """Fraction of the deck and base boards that have lost an end, 0-1."""
    displaced: Fraction = 0.0
    """Fraction of the deck boards and skids that are out of place by up to 10 mm, 0-1."""
    twisted: Fraction = 0.0
    """Fraction of the blocks that are turned, their corners by up to 10 mm, 0-1."""
    stains: Fraction = 0.0
    """Fraction of the deck boards with stains, 0-1."""
    stamps: Fraction = 1.0
    """Fraction of the brands and stencils that can still be read, 0-1."""

    def __post_init__(self) -> None:
        check_ranges(self)


def damaged(model: ObjectModel, wear: WearConfig, rng: np.random.Generator) -> ObjectModel:
    """Return ``model`` after use, called ``<name>~<tag>``, or ``<name>~look-<tag>`` where it has only aged.

    Its meaning is that of ``model``.

    The collision boxes stay, too: where a deck board is gone or broken, physics still sees the whole deck, and what is
    missing is never so much that a carton would stand on nothing.

    Args:
        model: A pallet of the catalog.
        wear: What happened to it.
        rng: Stream to draw from; two draws give two pallets.
    """
    members = aged(without_missing(members_of(model), wear.missing, rng), wear.age, rng)
    members = stained(nailed(with_broken(members, wear.broken, rng)), wear.stains, rng)
    members = branded(members, model, wear.stamps, rng)
    members = with_twisted(with_displaced(members, wear.displaced, rng), wear.twisted, rng)
    parts = tuple(part for member in members for part in member.parts)
    tag = f"{rng.integers(1 << 32):08x}"
    return replace(model, name=f"{model.name}~{SAME_SHAPE * _same_shape(model.parts, parts)}{tag}", parts=parts)


def _same_shape(built: tuple[Part, ...], used: tuple[Part, ...]) -> bool:
    """Return whether parts differ in their materials alone, as those of moulded pallets do."""
    return len(built) == len(used) and all(
        a.mesh is b.mesh and np.array_equal(a.T_object_part, b.T_object_part) and np.array_equal(a.scale, b.scale)
        for a, b in zip(built, used, strict=True)
    )
