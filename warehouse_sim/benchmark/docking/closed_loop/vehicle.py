"""The truck as it rolls, where it thinks that it is, and the law that it steers by.

The truck is a kinematic bicycle with its origin on the axle that does not steer (``scene.viewpoints.drives``), so that
each tick is an exact arc. The law is pure pursuit (Coulter 1992, "Implementation of the Pure Pursuit Path Tracking
Algorithm", CMU-RI-TR-92-01): the arc through the truck and a point of the line at the look-ahead distance. Near the
line its offset y over the way s obeys y'' + (2 / L) y' + (2 / L^2) y = 0: it decays with exp(-s / L).
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.settings import DRIVE, Drift
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.viewpoints.drives import FloorPose
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT, pose_on_floor

_STEEPEST = 0.7
"""Greatest fraction of the look-ahead that the offset may be: farther away the truck looks farther."""


@dataclass(frozen=True)
class Motion:
    """Where the truck is and how it moves."""

    pose: FloorPose
    speed: float = 0.0
    steering: float = 0.0
    """Of the wheel (rad), positive turns left."""

    @property
    def curvature(self) -> float:
        """Of the way of its origin (1/m)."""
        return float(np.tan(self.steering) / FORKLIFT.wheelbase)

    def after(self, speed: float, curvature: float) -> tuple["Motion", float]:
        """Return the motion one tick after an order, and the way driven (m).

        Args:
            speed: Wanted (m/s), >= 0.
            curvature: Wanted (1/m); no more than the truck's least radius allows.
            config: How fast speed and steering follow.
        """
        wanted = wheel_for(curvature)
        turn, gain = DRIVE.steer_rate * DRIVE.tick, DRIVE.acceleration * DRIVE.tick
        steering = self.steering + float(np.clip(wanted - self.steering, -turn, turn))
        moving = max(self.speed + float(np.clip(speed - self.speed, -gain, gain)), 0.0)
        way = DRIVE.tick * (self.speed + moving) / 2.0
        bend = float(np.tan(steering) / FORKLIFT.wheelbase)
        return Motion(self.pose.after(way, bend), moving, steering), way


class Odometry:
    """Where the truck thinks that it is; it begins at the ground truth.

    Args:
        start: Of the truck.
        drift: What is wrong with it.
        rng: Samples the errors of this approach.
    """

    def __init__(self, start: FloorPose, drift: Drift, rng: np.random.Generator) -> None:
        self.pose = start
        self.scale = 1.0 + float(rng.normal(0.0, drift.scale)) if drift.scale else 1.0
        self._turn = float(np.deg2rad(rng.normal(0.0, drift.turn_deg))) if drift.turn_deg else 0.0
        self._noise, self._rng = float(np.deg2rad(drift.noise_deg)), rng

    def add(self, way: float, curvature: float) -> None:
        """Take over a way (m, >= 0) along an arc (1/m)."""
        if way <= 0.0:
            return
        wrong = self._turn * way + (self._noise * float(np.sqrt(way) * self._rng.normal()) if self._noise else 0.0)
        turned, measured = curvature * way + wrong, self.scale * way
        self.pose = self.pose.after(measured, turned / measured)

    @property
    def T_odom_vehicle(self) -> Transform:
        """The pose as a transform."""
        return pose_on_floor(self.pose.x, self.pose.y, self.pose.yaw)


def wheel_for(curvature: float) -> float:
    """Return where the wheel must be (rad) for a curvature (1/m), or as near as the truck's least radius allows."""
    most = 1.0 / FORKLIFT.min_radius
    return float(np.arctan(np.clip(curvature, -most, most) * FORKLIFT.wheelbase))


def pursue(along: float, aside: float, turned: float) -> float:
    """Return the curvature (1/m) that leads onto a line.

    Args:
        along: Way to where the truck stops on the line (m).
        aside: Offset of the truck to the left of the line (m).
        turned: Heading of the truck against it (rad), positive to the left.
    """
    least, most = DRIVE.look_ahead
    ahead = max(float(np.clip(DRIVE.look_fraction * along, least, most)), abs(aside) / _STEEPEST)
    forward = float(np.sqrt(ahead**2 - aside**2))
    left = -np.sin(turned) * forward - np.cos(turned) * aside
    return float(2.0 * left / ahead**2)


def slow_down(along: float) -> float:
    """Return the speed (m/s) at which the truck can still stop within a way (m), at half of its braking."""
    return float(min(DRIVE.speed, np.sqrt(DRIVE.acceleration * max(along, 0.0))))
