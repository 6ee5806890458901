"""Unit loads that stand on the open floor of the aisle, turned any way."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig, build_unit_load

_HEADROOM, _CARRIER_HEADROOM = 1.3, 1.8
"""Greatest height of a load on the floor (m), and where carriers stand, which may be as tall as a roll container."""
_TRIES = 200
_EDGE = 0.8
"""Least distance from a load's centre to a rack's front (m)."""
_CLEARANCE = 0.4
"""Least distance between two loads on the floor (m)."""


@dataclass(frozen=True)
@ranged
class StagingConfig:
    """Unit loads on the floor of the aisle."""

    count: Annotated[Distribution, Range(0, 40, whole=True)] = field(default=Distribution.uniform(3, 6))
    """Loads on the floor, a whole number, 0-40."""
    yaw_deg: Annotated[Distribution, Range(-360, 360, "deg")] = field(default=Distribution.uniform(-180.0, 180.0))
    """Heading of a pallet's long edge about the vertical (deg), -360 to 360."""
    depth: Annotated[Distribution, Range(0.8, 30, "m")] = field(default=Distribution.uniform(1.6, 5.5))
    """Distance from the first rack's front to a load's centre (m), 0.8-30; the far end of the aisle limits it too."""


def stage_loads(
    draft: SceneDraft,
    config: StagingConfig,
    loads: UnitLoadConfig,
    area: Area,
    rng: np.random.Generator,
) -> None:
    """Put loads on the floor of the aisle ``area``.

    Raises:
        PlacementError: The floor is too small for so many loads.
    """
    count = config.count.sample_count(rng)
    standing: list[OrientedBox] = []
    fixed = draft.solids().boxes  # bins, rails and signs stand on the floor before loads come
    for number in range(count):
        headroom = _CARRIER_HEADROOM if loads.carrier_fraction > 0.0 else _HEADROOM
        load, stack = build_unit_load(headroom, loads, rng, on_floor=True), BoxStack.of(standing)
        for _ in range(_TRIES):
            position = np.array([rng.uniform(area.x_min, area.x_max), area.y_max - config.depth.sample(rng), 0.0])
            T_world_load = make_transform(rotation_z(np.deg2rad(config.yaw_deg.sample(rng))), position)
            box = load.envelope.placed(T_world_load)
            if position[1] >= area.y_min + _EDGE and stack.clear_of(box, _CLEARANCE) and fixed.clear_of(box, 0.0):
                break
        else:
            raise PlacementError(
                f"no room for load {number + 1} of {count} on the floor after {_TRIES} tries; "
                "lower staging.count or staging.depth"
            )
        standing.append(box)
        load.add_to(draft, T_world_load)
