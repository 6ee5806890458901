"""What carries a camera: the outlines of a counterbalance truck and of a mobile robot.

Vehicle frame: origin on the floor under the middle of the axle that does not steer, x forward, y left, z up. A vehicle
moves along its own x there, which makes the kinematic bicycle model exact (see ``paths``).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH, FORK_SPREAD, FORK_WIDTH
from warehouse_sim.catalog.traffic.trucks import FORKLIFT_HEIGHT, FORKLIFT_LENGTH, FORKLIFT_WIDTH
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z

FORK_TRAVEL_HEIGHT = 0.15
"""Upper face of the lowered forks above the floor (m) while driving; practical prior."""
_GROUND = 0.06
"""The body begins here (m): thresholds and what lies flat on the floor are driven over."""
_LOAD_AXLE = 0.47
"""From the load axle to the forks' faces (m), as on the catalog's truck."""


@dataclass(frozen=True)
class Vehicle:
    """Outline of a vehicle with lowered forks, if it has any (m)."""

    width: float
    height: float
    rear: float
    """x of its rear end, < 0."""
    front: float
    """x of the body's front: of the forks' faces on a truck."""
    wheelbase: float
    """From the axle that does not steer to the one that does."""
    min_radius: float
    """Least radius of the circle that its origin drives."""
    fork_length: float = 0.0
    """How far the forks reach beyond the front."""

    @property
    def tip(self) -> float:
        """Return x of what touches a load first (m)."""
        return self.front + self.fork_length

    def boxes(self, T_world_vehicle: Transform, lift: float = 0.0) -> Sequence[OrientedBox]:
        """Return body and forks in the world.

        Args:
            T_world_vehicle: The vehicle's pose.
            lift: How far the forks are raised above their travel height (m).
        """
        body = np.array([self.front - self.rear, self.width, self.height - _GROUND])
        found = [_box(T_world_vehicle, (self.rear + self.front) / 2, (self.height + _GROUND) / 2, body)]
        if self.fork_length:
            forks = np.array([self.fork_length, FORK_SPREAD + FORK_WIDTH, 0.08])
            middle = FORK_TRAVEL_HEIGHT - 0.04 + lift
            found.append(_box(T_world_vehicle, (self.front + self.tip) / 2, middle, forks))
        return found


FORKLIFT = Vehicle(
    width=FORKLIFT_WIDTH,
    height=FORKLIFT_HEIGHT,
    rear=_LOAD_AXLE + FORK_LENGTH - FORKLIFT_LENGTH,
    front=_LOAD_AXLE,
    wheelbase=1.19,
    min_radius=0.8,
    fork_length=FORK_LENGTH,
)
"""The catalog's counterbalance truck: the load axle is fixed, the rear axle steers. Radius: practical prior."""
AMR = Vehicle(width=0.65, height=1.0, rear=-0.48, front=0.48, wheelbase=0.6, min_radius=0.3)
"""A mobile robot with two driven wheels in its middle and a sensor post; practical prior, no single maker's."""


def pose_on_floor(x: float, y: float, yaw: float) -> Transform:
    """Return ``T_world_vehicle`` for an origin (m) and a heading (rad)."""
    return make_transform(rotation_z(yaw), np.array([x, y, 0.0]))


def _box(T_world_vehicle: Transform, x: float, z: float, size: np.ndarray) -> OrientedBox:
    return OrientedBox(T_world_vehicle @ make_transform(translation=np.array([x, 0.0, z])), size)
