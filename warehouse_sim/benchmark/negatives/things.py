"""What stands before a camera in place of a pallet that a truck can take."""

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.parts import box_part
from warehouse_sim.catalog.traffic.shapes import assembled
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.schema import ObjectModel

PALLET, BLOCKED, GHOST, NOTHING = "pallet", "blocked pocket", "ghost pocket", "nothing"
KINDS = (PALLET, GHOST, "three cartons", "shelf", BLOCKED, NOTHING)
"""The first is what is to be accepted, with the score of the surest 95 of 100."""
MODEL = "epal1"
"""Of all pallets."""
DECK = 0.144
"""Height of an EPAL 1 (m), UIC 435-2."""
_POCKET, _FRONT = 0.2275, 0.8
"""Width of a pocket and of the front of an EPAL 1 (m)."""

Placed = list[tuple[ObjectModel, Transform]]


def things(kind: str, rng: np.random.Generator) -> Placed:
    """Return what is put on the floor, about the origin, its front towards -x; the pallet, if there is one, first."""
    if kind == NOTHING:
        return []
    if kind == PALLET:
        return [*_pallet(), *_load()]
    if kind == BLOCKED:
        side = rng.choice([-1.0, 1.0]) * (_POCKET / 2 + 0.0725)
        return [*_pallet(), *_load(), *_blocking(side, rng)]
    if kind == GHOST:
        return [*_pallet(), *_load(), *_ghost(rng)]
    if kind == "shelf":
        bay = catalog_object("shelf_bay")
        return [(bay, stands_at(0.0, 0.0, bay.size[2] / 2, np.pi / 2 if bay.size[0] > bay.size[1] else 0.0))]
    return _cartons(rng)


def _pallet() -> Placed:
    pallet = catalog_object("epal1")
    return [(pallet, stands_at(0.0, 0.0, pallet.size[2] / 2))]


def _load() -> Placed:
    carton = catalog_object("carton_600x400x320")
    height = DECK + carton.size[2] / 2
    return [(carton, stands_at(x, y, height)) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]


def _ghost(rng: np.random.Generator) -> Placed:
    """Return a low carton beside the pallet, a pocket's width away, and a carton that spans the gap."""
    side, gap = rng.choice([-1.0, 1.0]), _POCKET + rng.uniform(-0.03, 0.03)
    low, upper = catalog_object("carton_300x200x150"), catalog_object("carton_600x400x320")
    beside = _FRONT / 2 + gap + low.size[1] / 2
    over = _FRONT / 2 + (gap + low.size[1]) / 2
    x = -0.6 + low.size[0] / 2
    return [
        (low, stands_at(x, side * beside, low.size[2] / 2)),
        (upper, stands_at(-0.6 + upper.size[1] / 2, side * (over + 0.1), low.size[2] + upper.size[2] / 2, np.pi / 2)),
    ]


def _cartons(rng: np.random.Generator) -> Placed:
    """Return three low cartons as far apart as the blocks of a pallet, twice as deep as they are wide, under a load."""
    low, gap = catalog_object("carton_300x200x150"), _POCKET + rng.uniform(-0.04, 0.06)
    steps = np.array([-1.0, 0.0, 1.0]) * (gap + low.size[1])
    rows = [(low, stands_at(x, y, low.size[2] / 2)) for x in (-0.45, 0.0, 0.45) for y in steps]
    upper = catalog_object("carton_600x400x320")
    height = low.size[2] + upper.size[2] / 2
    return [*rows, *((upper, stands_at(x, y, height)) for x in (-0.3, 0.3) for y in (-0.2, 0.2))]


def _blocking(y: float, rng: np.random.Generator) -> Placed:
    """Return a block of wood in the pocket, or a carton on the floor close before it."""
    if rng.random() < 0.5:
        carton = catalog_object("carton_300x200x200")
        return [(carton, stands_at(-0.6 - carton.size[0] / 2 - rng.uniform(0.01, 0.2), y, carton.size[2] / 2))]
    size = (0.3, 0.2, 0.094)
    part = box_part(size, (0.0, 0.0, size[2] / 2), "pallet_wood_grey")
    body = OrientedBox(make_transform(translation=np.array([0.0, 0.0, size[2] / 2])), np.array(size))
    block = assembled("pocket_block", "clutter", 9990, [part], [body], 3.0)
    return [(block, stands_at(-0.6 + 0.15 + rng.uniform(-0.1, 0.1), y, size[2] / 2))]


def stands_at(x: float, y: float, z: float, yaw: float = 0.0) -> Transform:
    """Return a place (m) with a heading (rad)."""
    return make_transform(rotation_z(yaw), np.array([x, y, z]))
