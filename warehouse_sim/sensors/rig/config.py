"""What a recipe says about its sensors."""

import re
from dataclasses import dataclass, field, fields
from typing import Annotated, Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors.lidar import LidarConfig
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rig.camera import CAMERA_PRESETS, CameraConfig
from warehouse_sim.sensors.rig.mount import Mount, MountedLidar
from warehouse_sim.sensors.rig.shipped import rig_settings
from warehouse_sim.sensors.stereo import StereoConfig

_LIDAR_NAME = re.compile("[a-z][a-z0-9]*")
_MOST_LIDARS = 16
_TAKEN_NAMES = ("ids", "beams")


@dataclass(frozen=True)
@ranged
class RigConfig:
    """One RGB-D camera; if wanted, a second camera to its right and LiDARs. ``rig: NAME`` takes a shipped one."""

    camera: CameraConfig = CAMERA_PRESETS["kitti"]
    """A preset's name (kitti) or width, height, focal_px."""
    rgbd: RgbdConfig = field(default_factory=RgbdConfig)
    """Noise of colour and depth."""
    lidar: LidarConfig | None = field(default_factory=LidarConfig)
    """Beams and noise of the main LiDAR; null = none."""
    lidar_position: Annotated[tuple[float, float, float], Range(-20, 20, "m")] = (-0.27, 0.0, 0.08)
    """Where the LiDAR sits as seen from the camera: forward, left, up (m), -20 to 20; KITTI's is behind and above."""
    lidar_mount: Mount | None = None
    """Instead of ``lidar_position``: place and direction of the main LiDAR on the camera or on the vehicle."""
    lidars: dict[str, MountedLidar] = field(default_factory=dict)
    """More LiDARs by name (small letters and digits)."""
    right: StereoConfig | None = None
    """The second camera; null = none."""
    clean: bool = False
    """Whether datasets hold the clean depth and colour beside what the cameras read."""
    camera_height: Annotated[float, Range(0.1, 20, "m")] | None = None
    """Height of the camera above the floor (m), 0.1-20, where the recipe's viewpoints say none; null = their own."""

    def __post_init__(self) -> None:
        for name in self.lidars:
            if not _LIDAR_NAME.fullmatch(name) or name in _TAKEN_NAMES:
                raise ValueError(
                    f"the name of a LiDAR is small letters and digits, not ids or beams; found {shown(name)}"
                )
        if len(self.lidars) > _MOST_LIDARS:
            raise ValueError(f"lidars must be at most {_MOST_LIDARS} beside the main one, found {len(self.lidars)}")
        if self.lidars and self.lidar is None:
            raise ValueError("lidars are those beside the main one: give lidar, too")

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "RigConfig":
        """Read settings, or the name of a rig under ``rig`` with what replaces its settings.

        Raises:
            ConfigError: Unknown rig or setting.
        """
        if not isinstance(data, dict):
            raise ConfigError(f"{where}: expected a mapping of settings, found {shown(data)}")
        own = {key: value for key, value in data.items() if key != "rig"}
        shipped = rig_settings(data["rig"], f"{where}: rig") if "rig" in data else {}
        return from_mapping(cls, shipped | own, where)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back; additions to one camera and one LiDAR only where there are any."""
        added = ("lidar_mount", "lidars", "right", "clean", "camera_height")
        plain = {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}
        return {name: value for name, value in plain.items() if name not in added or value}

    def make_camera(self) -> PinholeCamera:
        """Return the rig's camera."""
        return self.camera.make()

    def T_camera_lidar(self, viewpoint: Viewpoint | None = None) -> Transform:
        """Return the main LiDAR's pose (x forward, y left, z up) in the camera frame (x right, y down, z forward).

        Args:
            viewpoint: Where camera and vehicle are; needed for a LiDAR on the vehicle.

        Raises:
            ConfigError: The LiDAR sits on a vehicle, but nothing carries the camera.
        """
        forward, left, up = self.lidar_position
        mount = self.lidar_mount or Mount(forward=forward, left=left, up=up)
        return mount.T_camera_sensor(viewpoint)
