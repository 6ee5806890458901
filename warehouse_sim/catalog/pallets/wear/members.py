"""A pallet as members, the pieces that a hammer or a fork can move one by one, with what sticks to each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import make_transform, rotation_z
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
