"""One vehicle on its way: where its camera is at any moment."""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import Mounting
from warehouse_sim.scene.viewpoints.paths import FloorPose, Path, SpeedProfile
from warehouse_sim.scene.viewpoints.vehicles import pose_on_floor
from warehouse_sim.schema import ObjectInstance, Viewpoint


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
