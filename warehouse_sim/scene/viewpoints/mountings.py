"""Where cameras sit on vehicles. No source with numbers was found for any of it: all values are practical priors.

Fork cameras are usual 0.1-0.4 m above the forks, mast cameras at 1.8-2.2 m looking 10-25 degrees down, cameras on the
overhead guard at 2.1-2.4 m, those of mobile robots at 0.3-1.0 m, those under a roof at 4-8 m.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.pose import Transform, level_camera
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.viewpoints.vehicles import AMR, FORK_TRAVEL_HEIGHT, FORKLIFT, Vehicle

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
