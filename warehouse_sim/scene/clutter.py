"""Clutter: small things that stand about, most on the floor beside what stands along the aisle, some on shelves."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.shipped import CLUTTER
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.site import Strip

_TRIES = 40
_EDGE = 0.9
"""Width of the strip along either side of the aisle that is its edge (m)."""
_BESIDE = 0.85
"""Fraction of what lies on the floor that stands along the aisle's sides; the rest stands anywhere."""
_CLEARANCE = 0.05
"""Least distance between any two of them and to everything else (m)."""
_LOW, _HIGH = 0.011, 2.0
"""Paint up to the first height, and what begins above the second, is in nobody's way (m)."""
_HANDY = ("bucket", "canister", "extension_reel", "film_heap", "film_roll", "film_rolls", "flat_cartons", "strap_roll",
          "toolbox")  # fmt: skip
"""What people put down on a shelf."""
_LIFT, _AIR = 0.003, 0.002
"""By how much the room of a thing on a shelf is lifted off it, and its least distance to all else (m)."""


@dataclass(frozen=True)
@ranged
class ClutterConfig:
    """How much of it there is."""

    count: Annotated[Distribution, Range(0, 60, whole=True)] = field(default=Distribution.constant(0))
    """Things on the floor of the aisle, 0-60; fewer where no more find a place."""
    on_shelves: Annotated[Distribution, Range(0, 200, whole=True)] = field(default=Distribution.constant(0))
    """Things left on shelves and on rack decks, 0-200; fewer where no more find a place."""


def add_clutter(draft: SceneDraft, config: ClutterConfig, area: Area, rng: np.random.Generator) -> None:
    """Stand clutter on the floor of ``area``, clear of everything there; what finds no place is left out.

    Args:
        draft: Where to add it.
        config: How much of it.
        area: Floor of the aisle.
        rng: Where, which and which way.
    """
    count = config.count.sample_count(rng)
    if count == 0:
        return
    crowd = draft.crowd(_LOW, _HIGH)
    for _ in range(count):
        model = catalog_object(sorted(CLUTTER)[int(rng.integers(len(CLUTTER)))])
        beside = bool(rng.random() < _BESIDE)
        for _ in range(_TRIES):
            T_world_object = _sample_place(float(model.size[2]), area, beside, rng)
            if crowd.takes([OrientedBox(T_world_object, model.size)], _CLEARANCE):
                draft.add(model, T_world_object)
                break


def _sample_place(height: float, area: Area, beside: bool, rng: np.random.Generator) -> Transform:
    x, yaw = rng.uniform(area.x_min, area.x_max), rng.uniform(-np.pi, np.pi)
    y = rng.uniform(area.y_min, area.y_max)
    if beside:
        depth = min(_EDGE, (area.y_max - area.y_min) / 2)
        into = rng.uniform(0.0, depth)
        y = area.y_min + into if rng.random() < 0.5 else area.y_max - into
    return make_transform(rotation_z(yaw), np.array([x, y, height / 2]))


def clutter_shelves(
    draft: SceneDraft, config: ClutterConfig, strips: Sequence[Strip], rng: np.random.Generator
) -> None:
    """Leave clutter on shelves and decks, clear of everything there; what finds no place is left out.

    Args:
        draft: Where to add it.
        config: How much of it.
        strips: Surfaces that it may stand on.
        rng: Where, which and which way.
    """
    count = config.on_shelves.sample_count(rng)
    if count == 0 or not strips:
        return
    crowd = draft.crowd()
    for _ in range(count):
        for _ in range(_TRIES):
            model = catalog_object(_HANDY[int(rng.integers(len(_HANDY)))])
            T_world_object = _sample_on_shelf(strips[int(rng.integers(len(strips)))], model.size, rng)
            if T_world_object is None:
                continue
            lifted = make_transform(translation=np.array([0.0, 0.0, _LIFT])) @ T_world_object
            if crowd.takes([OrientedBox(lifted, model.size)], _AIR):
                draft.add(model, T_world_object)
                break


def _sample_on_shelf(strip: Strip, size: np.ndarray, rng: np.random.Generator) -> Transform | None:
    """Return the pose of something of ``size`` (m) within a strip; None where it is too large for it as it lies."""
    turn = rotation_z(rng.uniform(-np.pi, np.pi))
    half = np.abs(turn) @ size / 2
    room = np.array([strip.length / 2 - half[0], strip.depth / 2 - half[1], strip.headroom - 2 * half[2] - _LIFT])
    if room.min() < 0.0:
        return None
    at = np.array([rng.uniform(-room[0], room[0]), strip.depth / 2 + rng.uniform(-room[1], room[1]), half[2]])
    return strip.T_world_strip @ make_transform(turn, at)
