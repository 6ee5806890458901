"""Drives: paths of straights and circle arcs on the floor, how fast they are driven, and where the camera is then.

The origin of a vehicle is on its axle that does not steer, so it never slips sideways: with speed v and curvature k the
heading turns by v k a second. This is the kinematic bicycle model (Rajamani, Vehicle Dynamics and Control, 2012, sec.
2.2) for the axle that does not steer, where k = tan(steering angle) / wheelbase.
"""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import Mounting, pose_on_floor
from warehouse_sim.schema import ObjectInstance, Viewpoint


@dataclass(frozen=True)
class Arc:
    """A piece of a path."""

    length: float
    """Metres, >= 0."""
    curvature: float = 0.0
    """Reciprocal of the radius (1/m), positive to the left; 0 = straight."""


@dataclass(frozen=True)
class FloorPose:
    """Place (m) and heading (rad, about world z, 0 along +x) on the floor."""

    x: float
    y: float
    yaw: float

    def after(self, distance: float, curvature: float) -> "FloorPose":
        """Return the pose ``distance`` (m, negative = backwards) further along a circle or straight."""
        turned = self.yaw + curvature * distance
        if abs(curvature) < 1e-9:
            return FloorPose(self.x + distance * np.cos(self.yaw), self.y + distance * np.sin(self.yaw), self.yaw)
        x = self.x + (np.sin(turned) - np.sin(self.yaw)) / curvature
        y = self.y + (np.cos(self.yaw) - np.cos(turned)) / curvature
        return FloorPose(float(x), float(y), float(turned))


@dataclass(frozen=True)
class Path:
    """A start and the pieces that follow."""

    start: FloorPose
    arcs: tuple[Arc, ...]

    @classmethod
    def ending_at(cls, end: FloorPose, arcs: tuple[Arc, ...]) -> "Path":
        """Return the path of these pieces that ends at ``end``."""
        start = end
        for arc in reversed(arcs):
            start = start.after(-arc.length, arc.curvature)
        return cls(start, arcs)

    @property
    def length(self) -> float:
        """Metres from start to end."""
        return sum(arc.length for arc in self.arcs)

    def part(self, first: float, last: float) -> "Path":
        """Return the path between two distances (m) from its start, ``first`` <= ``last``."""
        arcs, begin = [], 0.0
        for arc in self.arcs:
            kept = min(last, begin + arc.length) - max(first, begin)
            if kept > 0.0:
                arcs.append(Arc(kept, arc.curvature))
            begin += arc.length
        return Path(self.at(first)[0], tuple(arcs))

    def at(self, distance: float) -> tuple[FloorPose, float]:
        """Return pose and curvature (1/m) ``distance`` (m) from the start; beyond the end it goes on straight."""
        pose, rest = self.start, distance
        for arc in self.arcs:
            if rest <= arc.length:
                return pose.after(rest, arc.curvature), arc.curvature
            pose, rest = pose.after(arc.length, arc.curvature), rest - arc.length
        return pose.after(rest, 0.0), 0.0


@dataclass(frozen=True)
class SpeedProfile:
    """Speed over time as a trapezoid: up to the peak, on at the peak, down to rest at the path's end."""

    length: float
    """Of the path (m), > 0."""
    peak: float
    """Largest speed (m/s), > 0."""
    acceleration: float
    """Of speeding up and braking (m/s^2), > 0."""
    rolling: bool
    """Whether it begins at the peak instead of at rest."""

    @classmethod
    def over(cls, length: float, speed: float, acceleration: float, rolling: bool = False) -> "SpeedProfile":
        """Return the profile over ``length`` (m) that reaches ``speed`` (m/s) if the path is long enough for it."""
        # v^2 = 2 a s: braking takes all of a rolling start's path and half of a standing start's.
        reachable = np.sqrt((2.0 if rolling else 1.0) * acceleration * length)
        return cls(length, float(min(speed, reachable)), acceleration, rolling)

    @property
    def duration(self) -> float:
        """Seconds from start to rest."""
        return self._rise + self._hold + self._ramp

    def at(self, time: float) -> tuple[float, float]:
        """Return the distance from the start (m) and the speed (m/s) at ``time`` (s), 0 to ``duration``."""
        left = self.duration - time
        if left < self._ramp:
            return self.length - self.acceleration * left**2 / 2, self.acceleration * left
        if time < self._rise:
            return self.acceleration * time**2 / 2, self.acceleration * time
        return self.acceleration * self._rise**2 / 2 + self.peak * (time - self._rise), self.peak

    @property
    def _ramp(self) -> float:
        return self.peak / self.acceleration

    @property
    def _rise(self) -> float:
        return 0.0 if self.rolling else self._ramp

    @property
    def _hold(self) -> float:
        ramps = self.peak**2 / (2 * self.acceleration) * (1 if self.rolling else 2)
        return max(0.0, self.length - ramps) / self.peak


@dataclass(frozen=True)
class Mount:
    """One camera as it is mounted for a drive."""

    kind: str
    mounting: Mounting
    height: float
    """Above the floor (m), lift included."""
    pitch: float
    """Tilt of the optical axis (rad), positive looks up."""
    lift: float
    """Of the forks above their travel height (m)."""
    roll: float = 0.0
    """Turn about the optical axis (rad)."""

    def view(self, pose: FloorPose) -> Viewpoint:
        """Return where the camera is while the vehicle stands at ``pose``."""
        T_world_vehicle = pose_on_floor(pose.x, pose.y, pose.yaw)
        T_world_camera = self.mounting.camera(T_world_vehicle, self.height, self.pitch, self.roll)
        return Viewpoint(T_world_camera, self.kind, T_world_vehicle=T_world_vehicle)

    def is_clear(self, pose: FloorPose, space: FreeSpace, clearance: float) -> bool:
        """Return whether camera and vehicle are clear of all objects at ``pose``; ``clearance`` (m) is the camera's."""
        return space.is_clear(self.view(pose), clearance, self.lift)


@dataclass(frozen=True, eq=False)
class Drive:
    """A path, how fast it is driven, and with which camera."""

    mount: Mount
    path: Path
    speed: SpeedProfile
    target: ObjectInstance | None = None
    """What it goes for; None along the aisle."""

    @property
    def duration(self) -> float:
        """Seconds from start to end."""
        return self.speed.duration

    def at(self, time: float) -> Viewpoint:
        """Return the view ``time`` (s) after the start; all its numbers follow from path and speed."""
        distance, speed = self.speed.at(time)
        pose, curvature = self.path.at(distance)
        return replace(
            self.mount.view(pose),
            velocity=(float(speed * np.cos(pose.yaw)), float(speed * np.sin(pose.yaw)), 0.0),
            yaw_rate=float(speed * curvature),
            time=float(time),
            target=self.target.instance_id if self.target else None,
        )
