"""A sensor of a rig: what it is, where it sits, and which random stream it draws from."""

from dataclasses import dataclass, field
from typing import Any

from warehouse_sim.config import convert, to_mapping
from warehouse_sim.errors import ConfigError, UnknownNameError, shown
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors import SENSORS
from warehouse_sim.sensors.lidar import LidarConfig
from warehouse_sim.sensors.rig.mount import CAMERA_FROM_BODY, Mount
from warehouse_sim.sensors.view import Sensor, is_camera, reads_light


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
