"""A sensor of a rig: what it is, where it sits and how it is turned, and which random stream it draws from."""

from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np

from warehouse_sim.config import convert, to_mapping
from warehouse_sim.errors import ConfigError, UnknownNameError, shown
from warehouse_sim.geometry.level_view import is_level, levelled
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors import SENSORS
from warehouse_sim.sensors.lidar import LidarConfig
from warehouse_sim.sensors.view import Sensor, is_camera, reads_light

CAMERA_FROM_BODY = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Rotation from axes x forward, y left, z up to a camera's x right, y down, z forward."""


@dataclass(frozen=True)
@ranged
class Mount:
    """A place and a direction on the rig; turned by yaw, then pitch, then roll about the axes that turn along."""

    carrier: Literal["camera", "upright", "vehicle"] = "camera"
    """Seen from the camera, with which it tilts and lifts; from there, but upright; or from the vehicle's origin."""
    forward: Annotated[float, Range(-20, 20, "m")] = 0.0
    """Along the optical axis, or along the vehicle (m), -20 to 20."""
    left: Annotated[float, Range(-20, 20, "m")] = 0.0
    """To the left (m), -20 to 20."""
    up: Annotated[float, Range(-20, 20, "m")] = 0.0
    """Upwards (m), -20 to 20."""
    roll_deg: Annotated[float, Range(-360, 360, "deg")] = 0.0
    """About the forward axis (deg), -360 to 360; positive lowers the right side."""
    pitch_deg: Annotated[float, Range(-360, 360, "deg")] = 0.0
    """About the left axis (deg), -360 to 360; positive looks up."""
    yaw_deg: Annotated[float, Range(-360, 360, "deg")] = 0.0
    """About the up axis (deg), -360 to 360; positive looks left."""

    def T_body_sensor(self) -> Transform:
        """Return the pose of the sensor (x forward, y left, z up) in the same axes of what carries it."""
        roll, pitch, yaw = np.deg2rad([self.roll_deg, self.pitch_deg, self.yaw_deg])
        rotation = rotation_z(yaw) @ rotation_y(-pitch) @ rotation_x(roll)
        return make_transform(rotation, np.array([self.forward, self.left, self.up]))

    def T_camera_sensor(self, viewpoint: Viewpoint | None = None) -> Transform:
        """Return the pose of the sensor (x forward, y left, z up) in the camera frame (x right, y down, z forward).

        Args:
            viewpoint: Where camera and vehicle are; not needed for what sits on the camera, nor on a level one upright.

        Raises:
            ConfigError: The sensor sits on a vehicle, but nothing carries the camera.
        """
        tilts = self.carrier == "upright" and viewpoint is not None and not is_level(viewpoint.T_world_camera)
        if self.carrier == "camera" or (self.carrier == "upright" and not tilts):
            return make_transform(CAMERA_FROM_BODY) @ self.T_body_sensor()
        if viewpoint is not None and tilts:
            T_camera_level = invert(viewpoint.T_world_camera) @ levelled(viewpoint.T_world_camera)
            return T_camera_level @ make_transform(CAMERA_FROM_BODY) @ self.T_body_sensor()
        if viewpoint is None or viewpoint.T_world_vehicle is None:
            raise ConfigError(
                "sensors: a sensor is mounted on the vehicle, but no vehicle carries this camera; "
                "mount it on the camera, or take another viewpoints.kind than free"
            )
        return invert(viewpoint.T_world_camera) @ viewpoint.T_world_vehicle @ self.T_body_sensor()


@dataclass(frozen=True)
class MountedSensor:
    """One sensor of a rig."""

    kind: str
    """Name of the sensor in ``SENSORS``."""
    sensor: Sensor
    """What reads."""
    mount: Mount
    """Where it sits."""
    stream: str
    """First words of the names of its random streams."""

    def T_camera_sensor(self, viewpoint: Viewpoint | None = None) -> Transform:
        """Return the pose of the sensor's own frame in the camera frame.

        Args:
            viewpoint: Where camera and vehicle are; not needed for what sits on the camera.

        Raises:
            ConfigError: The sensor sits on a vehicle, but nothing carries the camera.
        """
        T_camera_body = self.mount.T_camera_sensor(viewpoint)
        return T_camera_body @ make_transform(CAMERA_FROM_BODY.T) if is_camera(self.sensor) else T_camera_body

    @property
    def reads_light(self) -> bool:
        """Whether paired variants in another light, or with other noise of cameras, have a reading of their own."""
        return reads_light(self.sensor)

    def stream_of(self, viewpoint_index: int, noise_sample: int = 0) -> str:
        """Return the name of the random stream of one reading; draws of noise are those of what reads light."""
        draw = f" draw {noise_sample}" if noise_sample and self.reads_light else ""
        return f"{self.stream} {viewpoint_index}{draw}"


@dataclass(frozen=True)
class MountedLidar:
    """One more LiDAR of a rig."""

    lidar: LidarConfig
    """A preset's name, or ``model`` with what differs from it."""
    mount: Mount = field(default_factory=Mount)
    """Where it sits."""


@dataclass(frozen=True)
class FurtherSensor:
    """A sensor that a rig names as it is registered; its own settings stand beside ``sensor`` and ``mount``."""

    sensor: str
    """Name of the sensor in ``SENSORS``."""
    settings: Sensor
    """What it was set to."""
    mount: Mount = field(default_factory=Mount)
    """Where it sits."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "FurtherSensor":
        """Read ``{sensor: NAME, mount: {...}, any setting of that sensor: ...}``.

        Raises:
            ConfigError: The sensor is not registered, or a setting is not one of its own.
        """
        if not isinstance(data, dict) or not isinstance(data.get("sensor"), str):
            raise ConfigError(f"{where}: expected {{sensor: NAME}} with its settings, found {shown(data)}")
        if data["sensor"] == "lidar":
            raise ConfigError(f"{where}: a LiDAR is named under lidars, not under more")
        try:
            kind = SENSORS.get(data["sensor"])
        except UnknownNameError as problem:
            raise ConfigError(f"{where}: {problem}") from problem
        own = {key: value for key, value in data.items() if key not in ("sensor", "mount")}
        mount = convert(Mount, data.get("mount", {}), f"{where}: mount")
        settings = convert(kind, own, where)
        if taken := {"sensor", "mount"} & set(to_mapping(settings)):
            raise ConfigError(f"{where}: {data['sensor']} has settings that a rig keeps for itself: {sorted(taken)}")
        return cls(data["sensor"], settings, mount)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        return {"sensor": self.sensor, "mount": to_mapping(self.mount), **to_mapping(self.settings)}
