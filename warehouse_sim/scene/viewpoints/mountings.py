"""What carries a camera, and where cameras sit on it.

No source with numbers was found for any of it: all values are practical priors.

Fork cameras are usual 0.1-0.4 m above the forks, mast cameras at 1.8-2.2 m looking 10-25 degrees down, cameras on the
overhead guard at 2.1-2.4 m, those of mobile robots at 0.3-1.0 m, those under a roof at 4-8 m.

Vehicle frame: origin on the floor under the middle of the axle that does not steer, x forward, y left, z up. A vehicle
moves along its own x there, which makes the kinematic bicycle model exact (see ``drives``).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH, FORK_SPREAD, FORK_WIDTH
from warehouse_sim.catalog.traffic.trucks import FORKLIFT_HEIGHT, FORKLIFT_LENGTH, FORKLIFT_WIDTH
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, level_camera, make_transform, rotation_z
from warehouse_sim.scene.distribution import Distribution

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


ViewKind = Literal["level", "forklift_mast", "forklift_forks", "forklift_guard", "amr", "free", "post", "ceiling"]
"""Value of ``viewpoints.kind`` in a recipe."""


@dataclass(frozen=True)
class Mounting:
    """A camera in the middle of a vehicle, looking ahead."""

    vehicle: Vehicle | None
    """Outline that must be free of objects; None has none, and its origin is right under the camera."""
    forward: float
    """x of the optical centre in the vehicle frame (m)."""
    height: Distribution
    """Height above the floor with the forks lowered (m)."""
    pitch_deg: Distribution
    """Tilt of the optical axis (deg); negative looks down."""
    lifts: bool = False
    """Whether it is raised with the forks."""
    overhead: bool = False
    """Whether it hangs above what it looks at, so that its distance follows from height and pitch."""

    @property
    def tip(self) -> float:
        """Return x of what touches a load first (m)."""
        return self.vehicle.tip if self.vehicle else self.forward

    def camera(self, T_world_vehicle: Transform, height: float, pitch: float, roll: float = 0.0) -> Transform:
        """Return ``T_world_camera`` for a height above the floor (m), a pitch (rad, positive looks up) and a roll."""
        yaw = float(np.arctan2(T_world_vehicle[1, 0], T_world_vehicle[0, 0]))
        place = T_world_vehicle[:3, 3] + self.forward * T_world_vehicle[:3, 0]
        return level_camera(np.array([place[0], place[1], height]), yaw, pitch, roll)


MOUNTINGS: dict[str, Mounting] = {
    # A camera on a post of any height, always level: KITTI's view from a truck in the aisle.
    "level": Mounting(None, 0.0, Distribution.uniform(0.4, 3.5), Distribution.constant(0.0)),
    # On the inner mast, before the channels; goes up with the forks.
    "forklift_mast": Mounting(
        FORKLIFT, 0.42, Distribution.uniform(1.8, 2.2), Distribution.uniform(-25.0, -10.0), lifts=True
    ),
    # Between the fork tips, 0.1-0.4 m above the blades.
    "forklift_forks": Mounting(
        FORKLIFT,
        FORKLIFT.tip - 0.17,
        Distribution.uniform(FORK_TRAVEL_HEIGHT + 0.1, FORK_TRAVEL_HEIGHT + 0.4),
        Distribution.uniform(-5.0, 5.0),
        lifts=True,
    ),
    # On the front edge of the overhead guard; looks past the mast, which is not sampled.
    "forklift_guard": Mounting(FORKLIFT, -0.15, Distribution.uniform(2.1, 2.4), Distribution.uniform(-20.0, -5.0)),
    "amr": Mounting(AMR, 0.45, Distribution.uniform(0.3, 1.0), Distribution.uniform(-5.0, 5.0)),
    # On a post, a tripod or a hand-held stick: any height, mostly looking down.
    "post": Mounting(None, 0.0, Distribution.uniform(0.3, 3.5), Distribution.uniform(-30.0, 5.0)),
    # Under the roof, as surveillance and counting cameras hang.
    "ceiling": Mounting(None, 0.0, Distribution.uniform(4.0, 8.0), Distribution.uniform(-90.0, -40.0), overhead=True),
}
"""Kinds of cameras that stand on the floor; ``free`` is the one that nothing carries."""
CARRIERS: dict[str, str] = {"forklift": "forklift_mast", **{name: name for name in (*MOUNTINGS, "free")}}
"""What may carry a rig -> value of ``viewpoints.kind`` in a recipe."""


def carried_by(name: str) -> str:
    """Return the kind of viewpoints of what carries a rig.

    Raises:
        UnknownNameError: Nothing of that name carries one.
    """
    if name not in CARRIERS:
        raise UnknownNameError("carrier of a rig", name, list(CARRIERS))
    return CARRIERS[name]
