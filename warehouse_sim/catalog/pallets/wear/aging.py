"""Age as colour: which materials a surface goes through on its way from new to weathered."""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog.pallets.wear.members import Member

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
    moulded = _Draw.of(age, rng)  # what is moulded in one piece ages as one
    return [_older(member, age, moulded if member.role == "moulded" else _Draw.of(age, rng)) for member in members]


@dataclass(frozen=True)
class _Draw:
    """What chance does to one piece."""

    unevenness: float
    repaired: bool

    @classmethod
    def of(cls, age: float, rng: np.random.Generator) -> "_Draw":
        return cls(rng.normal(0.0, _UNEVENNESS), bool(rng.random() < _REPAIRED_FRACTION * age))


def _older(member: Member, age: float, draw: _Draw) -> Member:
    stages = next((line for line in STAGES if member.body.material in line), ())
    if not stages:
        return member
    first, last = stages.index(member.body.material), len(stages) - 1
    fraction = np.clip(age + draw.unevenness * np.sqrt(age), 0.0, 1.0) ** 1.2
    is_new = draw.repaired and member.role in _REPLACED
    stage = 0 if is_new else first + int(np.round(fraction * (last - first)))
    body = replace(member.body, material=stages[stage])
    return replace(member, body=body, parts=(body,))
