"""A pallet as members, the pieces that a hammer or a fork can move one by one, and what moves them.

Boards are gone, splintered or out of place, blocks are turned. Limits follow EPAL's rules of exchange
(epal-pallets.org): a pallet with a missing or splintered board is still met in use, a block may stand out by 10 mm.
Nothing here reaches farther than that into a pocket.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import solid_part
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.geometry.solids import prism
from warehouse_sim.schema import ObjectModel, Part

Role = Literal["deck", "base", "cross", "block", "stringer", "bracket", "moulded"]
"""A deck board, a board on the ground, a board between, a wooden block; a beam, steel or plastic that wear leaves in
place. What has another role, or none, only ages."""


@dataclass(frozen=True, eq=False)
class Member:
    """One piece of a pallet."""

    body: Part
    """The piece as built; a wooden one is a box parallel to the object's axes."""
    parts: tuple[Part, ...]
    """What it looks like now, in the object frame."""

    @property
    def role(self) -> str:
        """What it is in the pallet, one of ``Role``."""
        return self.body.role

    @property
    def axis(self) -> int:
        """The horizontal axis along which the piece is longest: 0 or 1."""
        return int(np.argmax(self.body.scale[:2]))

    @property
    def centre(self) -> Float[np.ndarray, " 3"]:
        """Middle of the piece as built (m)."""
        return self.body.T_object_part[:3, 3]

    def along(self, coordinate: Literal["centre", "size"]) -> float:
        """Return the centre or the length (m) along the piece."""
        return float((self.centre if coordinate == "centre" else self.body.scale)[self.axis])

    def aside(self, coordinate: Literal["centre", "size"]) -> float:
        """Return the centre or the width (m) at right angles to the piece, level."""
        return float((self.centre if coordinate == "centre" else self.body.scale)[1 - self.axis])

    def with_parts(self, *parts: Part) -> "Member":
        """Return the member with ``parts`` stuck to it."""
        return replace(self, parts=(*self.parts, *parts))

    def moved(self, shift: Sequence[float], angle: float) -> "Member":
        """Return the member turned about its upright axis by ``angle`` (rad), then shifted level (m)."""
        turn = make_transform(rotation_z(angle), self.centre + np.array([*shift, 0.0]))
        T = turn @ make_transform(translation=-self.centre)
        return replace(self, parts=tuple(replace(part, T_object_part=T @ part.T_object_part) for part in self.parts))


def members_of(model: ObjectModel) -> list[Member]:
    """Return the members of ``model`` in the order of its parts."""
    return [Member(part, (part,)) for part in model.parts]


def in_order(members: Sequence[Member], role: Role) -> list[int]:
    """Return the indices of the members of one role, sorted across their length."""
    found = [index for index, member in enumerate(members) if member.role == role]
    return sorted(found, key=lambda index: members[index].aside("centre"))


def parallel(members: Sequence[Member], indices: Sequence[int]) -> bool:
    """Return whether the members at ``indices`` all run the same way."""
    return len({members[index].axis for index in indices}) <= 1


FARTHEST = 0.010
"""How far a piece or its corner may leave its place (m)."""
WIDEST_GAP = 0.200
"""A board goes missing only where the gap stays narrower than this (m), the shorter edge of a 300 x 200 mm carton."""

_LOSS = {"deck": (0.04, 0.25), "base": (0.02, 0.06)}
_TIPS = (-0.4, -0.15, 0.1, 0.35)
_LONGEST_SPLINTER = 0.12
_FREE_FRACTION = 0.2


def without_missing(members: list[Member], fraction: float, rng: np.random.Generator) -> list[Member]:
    """Take away each inner deck board with probability ``fraction`` where the neighbours stay near enough."""
    order, gone = in_order(members, "deck"), set()
    for left, index, right in zip(order, order[1:], order[2:], strict=False):
        before, after = _gap(members[left], members[index]), _gap(members[index], members[right])
        opening = (1 + _FREE_FRACTION) * (before + after) + members[index].aside("size")
        if opening <= WIDEST_GAP and left not in gone and rng.random() < fraction:
            gone.add(index)
    return [member for index, member in enumerate(members) if index not in gone]


def with_broken(members: list[Member], fraction: float, rng: np.random.Generator) -> list[Member]:
    """Break one end off each deck or base board with probability ``fraction``."""
    return [_broken(member, rng) if member.role in _LOSS and rng.random() < fraction else member for member in members]


def with_displaced(members: list[Member], fraction: float, rng: np.random.Generator) -> list[Member]:
    """Shift and turn each deck board and skid with probability ``fraction``, never onto its neighbour."""
    result = list(members)
    for role in ("deck", "base"):
        order = in_order(members, role)
        if not parallel(members, order):  # boards of a frame hold each other in place
            continue
        for place, index in enumerate(order):
            if rng.random() < fraction:
                low = _gap_beside(members, order, place, -1) * rng.uniform(0.3, 1.0)
                high = _gap_beside(members, order, place, 1) * rng.uniform(0.3, 1.0)
                result[index] = _displaced(members[index], -low, high, rng)
    return result


def with_twisted(members: list[Member], fraction: float, rng: np.random.Generator) -> list[Member]:
    """Turn each wooden block with probability ``fraction``; no corner moves by more than ``FARTHEST``."""
    result = []
    for member in members:
        if member.role == "block" and rng.random() < fraction:
            limit = float(np.arcsin(FARTHEST / (max(member.body.scale[:2]) / 2)))
            member = member.moved((0.0, 0.0), rng.choice((-1.0, 1.0)) * rng.uniform(0.3, 1.0) * limit)
        result.append(member)
    return result


def _broken(member: Member, rng: np.random.Generator) -> Member:
    """Return the board without one end, with splinters where it tore."""
    low, high = _LOSS[member.role]
    length, width, axis = member.along("size"), member.aside("size"), member.axis
    lost = float(min(rng.uniform(low, high), 0.25 * length))
    end = float(rng.choice((-1.0, 1.0)))
    scale, T = member.body.scale.copy(), member.body.T_object_part.copy()
    scale[axis] -= lost
    T[axis, 3] -= end * lost / 2
    board = replace(member.body, scale=scale, T_object_part=T)
    material = member.body.material if rng.random() < 0.5 else "wood_broken"
    tear = member.along("centre") + end * (length / 2 - lost)
    return replace(member, body=board, parts=(board, *_splinters(member, tear, end, lost, width, material, rng)))


def _splinters(
    member: Member, tear: float, end: float, lost: float, width: float, material: str, rng: np.random.Generator
) -> list[Part]:
    count = int(rng.integers(5, 10))
    edges = np.sort(rng.uniform(-width / 2, width / 2, count - 1))
    edges = np.concatenate([[-width / 2], edges, [width / 2]])
    turn = rotation_z(0.0 if end > 0 else np.pi) if member.axis == 0 else rotation_z(end * np.pi / 2)
    parts = []
    for left, right in pairwise(edges):
        reach = float(min(0.01 + _LONGEST_SPLINTER * rng.random() ** 2, lost))
        thickness = float(member.body.scale[2]) * rng.uniform(0.4, 0.98)
        centre = member.centre.copy()
        centre[member.axis] = tear + end * reach / 2
        centre[1 - member.axis] += (left + right) / 2
        tip = _TIPS[int(rng.integers(len(_TIPS)))]
        wedge = prism(((-0.5, -0.5), (0.5, tip), (-0.5, 0.5)))
        parts.append(solid_part(wedge, (reach, right - left, thickness), tuple(centre), material, turn))
    return parts


def _gap_beside(members: Sequence[Member], order: Sequence[int], place: int, side: int) -> float:
    """Return how far (m) the board may go to one side: its fraction of the gap there, never more than ``FARTHEST``."""
    other = place + side
    if not 0 <= other < len(order):
        return FARTHEST
    gap = _gap(members[order[place]], members[order[other]])
    return float(np.clip(_FREE_FRACTION * gap, 0.0, FARTHEST))


def _gap(one: Member, other: Member) -> float:
    """Return the clear distance (m) between two parallel boards."""
    return abs(one.aside("centre") - other.aside("centre")) - (one.aside("size") + other.aside("size")) / 2


def _displaced(member: Member, low: float, high: float, rng: np.random.Generator) -> Member:
    """Return the board between two lines ``low`` and ``high`` (m) from its place, askew as far as they leave room."""
    near, far = rng.uniform(low, high, 2)  # where its two ends go
    reach = np.hypot(member.along("size"), member.aside("size"))
    angle = (far - near) / reach
    shift = [0.0, 0.0]
    shift[member.axis] = rng.uniform(-0.6, 0.6) * FARTHEST
    shift[1 - member.axis] = (near + far) / 2
    return member.moved(shift, angle if member.axis == 0 else -angle)
