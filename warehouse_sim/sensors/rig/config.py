"""What a recipe says about its sensors."""

import re
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import CAMERA, IMU, LIDAR, RIGHT
from warehouse_sim.schema.outputs import Output, WantedOutput, wanted
from warehouse_sim.sensors import SENSORS
from warehouse_sim.sensors.imu import Imu
from warehouse_sim.sensors.lidar import LidarConfig
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.depth.models import PRESETS as DEPTH_PRESETS
from warehouse_sim.sensors.rig.calibration import CalibrationConfig
from warehouse_sim.sensors.rig.camera import CAMERA_PRESETS, CameraConfig
from warehouse_sim.sensors.rig.mount import FurtherSensor, Mount, MountedLidar, MountedSensor
from warehouse_sim.sensors.rig.shipped import SensorChoice, rendered_choice, rig_settings
from warehouse_sim.sensors.stereo import StereoConfig

_LIDAR_NAME = re.compile("[a-z][a-z0-9]*")
_SENSOR_NAME = re.compile("[a-z][a-z0-9_]{0,60}")
_MOST_LIDARS = _MOST_FURTHER = 16
_TAKEN_NAMES = ("ids", "beams")


@dataclass(frozen=True)
@ranged
class RigConfig:
    """One RGB-D camera; if wanted, a second camera to its right, LiDARs and any registered sensor.

    ``rig: NAME`` takes a shipped one.
    """

    camera: CameraConfig = CAMERA_PRESETS["kitti"]
    """A preset's name (kitti, d435_720p) or width, height and focal_px or hfov_deg. A depth camera brings its depth."""
    rgbd: RgbdConfig = field(default_factory=RgbdConfig)
    """Noise of colour and depth."""
    choices: tuple[SensorChoice, ...] = ()
    """Cameras of which each scene draws one instead of ``rgbd``: names of depth presets, or name, depth and color."""
    lidar: LidarConfig | None = field(default_factory=LidarConfig)
    """Beams and noise of the main LiDAR; null = none."""
    lidar_position: Annotated[tuple[float, float, float], Range(-20, 20, "m")] = (-0.27, 0.0, 0.08)
    """Where the LiDAR stands upright as seen from the camera: forward, left, up (m), -20 to 20; KITTI's is behind."""
    lidar_mount: Mount | None = None
    """Instead of ``lidar_position``: place and direction of the main LiDAR on the camera or on the vehicle."""
    lidars: dict[str, MountedLidar] = field(default_factory=dict)
    """More LiDARs by name (small letters and digits)."""
    right: StereoConfig | None = None
    """The second camera; null = none."""
    imu: Imu | None = field(default_factory=Imu)
    """The inertial unit in the camera; null = none."""
    more: dict[str, FurtherSensor] = field(default_factory=dict)
    """Any other sensors by name: ``{sensor: REGISTERED, mount: {...}}`` and settings of that sensor."""
    calibration: CalibrationConfig | None = None
    """How the calibration that the rig states differs from the true one; null = it does not."""
    outputs: tuple[WantedOutput, ...] = ()
    """What datasets hold of an observation: any of rgb, depth, masks, amodal_masks, poses, lidar, right, readings
    and clean; ``default``, as nothing, is all but clean."""
    camera_height: Annotated[float, Range(0.1, 20, "m")] | None = None
    """Height of the camera above the floor (m), 0.1-20, where the recipe's viewpoints say none; null = their own."""

    def __post_init__(self) -> None:
        for name in self.lidars:
            if not _LIDAR_NAME.fullmatch(name) or name in _TAKEN_NAMES:
                raise ValueError(
                    f"the name of a LiDAR is small letters and digits, not ids or beams; found {shown(name)}"
                )
        named = [choice.name for choice in self.choices]
        if len(set(named)) < len(named):
            raise ValueError(f"every one of choices needs a name of its own, found {shown(named)}")
        if len(self.lidars) > _MOST_LIDARS:
            raise ValueError(f"lidars must be at most {_MOST_LIDARS} beside the main one, found {len(self.lidars)}")
        if self.lidars and self.lidar is None:
            raise ValueError("lidars are those beside the main one: give lidar, too")
        for name in self.more:
            if not _SENSOR_NAME.fullmatch(name):
                raise ValueError(
                    f"the name of a sensor is small letters, digits and _, 61 at most; found {shown(name)}"
                )
        if len(self.more) > _MOST_FURTHER:
            raise ValueError(f"more must be at most {_MOST_FURTHER} sensors, found {len(self.more)}")
        built_in = (
            CAMERA,
            *([] if self.lidar is None else [LIDAR]),
            *([] if self.right is None else [RIGHT]),
            *([] if self.imu is None else [IMU]),
        )
        names = [*built_in, *self.lidars, *self.more]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"every sensor of a rig needs a name of its own; {', '.join(twice)}: rename one")
        self._require_outputs()

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
        return from_mapping(cls, shipped | _with_depth(own), where)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back; additions to one camera and one LiDAR only where there are any."""
        added = ("choices", "lidar_mount", "lidars", "right", "more", "calibration", "outputs", "camera_height")
        plain = {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}
        return {name: value for name, value in plain.items() if name not in added or value}

    def make_camera(self) -> PinholeCamera:
        """Return the rig's camera."""
        return self.camera.make()

    def sample_sensor(self, rng: np.random.Generator) -> SensorChoice:
        """Return the RGB-D camera of one scene, and which built one it is.

        It is one of ``choices``; without any it is the rig's own, which has no name.
        """
        choice = rendered_choice(self.choices, rng) if self.choices else SensorChoice("", self.rgbd)
        return replace(choice, rgbd=replace(choice.rgbd, depth=choice.rgbd.depth.sampled(rng)))

    @property
    def wanted(self) -> tuple[Output, ...]:
        """What datasets hold of an observation, as far as the rig has it."""
        return tuple(name for name in wanted(self.outputs) if self._has(name))

    def output_of(self, sensor: str) -> Output:
        """Return the output that holds what a sensor other than the camera reads."""
        if sensor in (LIDAR, *self.lidars):
            return "lidar"
        return "right" if sensor == RIGHT else "readings"

    def reading(self) -> dict[str, MountedSensor]:
        """Return the sensors of ``mounted`` that must read, so that all that is wanted can be made.

        Those that a registered package brings may look at what others read: then all do.
        """
        others_look = "readings" in self.wanted and bool(self.more)
        return {
            name: item
            for name, item in self.mounted().items()
            if name == CAMERA or others_look or self.output_of(name) in self.wanted
        }

    def mounted(self) -> dict[str, MountedSensor]:
        """Return all sensors of the rig by name, in the order in which they read; the camera is the first."""
        found = {CAMERA: MountedSensor("rgbd", self.rgbd, Mount(), "rgbd")}
        if self.lidar is not None:
            forward, left, up = self.lidar_position
            mount = self.lidar_mount or Mount("upright", forward, left, up)
            found[LIDAR] = _mounted("lidar", (self.lidar,), mount, "lidar")
        for name, item in self.lidars.items():
            found[name] = _mounted("lidar", (item.lidar,), item.mount, f"lidar {name}")
        if self.right is not None:
            at_baseline = Mount(left=-self.right.baseline)
            found[RIGHT] = _mounted("stereo", (self.right, self.rgbd.color), at_baseline, "right")
        if self.imu is not None:
            found[IMU] = MountedSensor("imu", self.imu, Mount(), "imu")
        for name, other in self.more.items():
            found[name] = MountedSensor(other.sensor, other.settings, other.mount, f"sensor {name}")
        return found

    def _has(self, output: WantedOutput) -> bool:
        sensors = {"lidar": self.lidar, "right": self.right, "readings": self.imu or self.more or None}
        return output not in sensors or sensors[output] is not None

    def _require_outputs(self) -> None:
        """Reject outputs that are named twice, cannot be left out, or need a sensor that the rig lacks."""
        if len(set(self.outputs)) < len(self.outputs):
            raise ValueError(f"outputs must name each once, found {shown(list(self.outputs))}")
        if "poses" not in self.wanted:
            raise ValueError(f"outputs must hold poses, which all labels are of; add it to {shown(list(self.outputs))}")
        for name in (name for name in self.outputs if not self._has(name)):
            raise ValueError(f"outputs: {name} is wanted, but the rig has no such sensor; add it, or leave {name} out")


def _with_depth(settings: dict[str, Any]) -> dict[str, Any]:
    """Return settings whose camera brings its own depth where it is a depth camera and nothing says otherwise."""
    camera, rgbd = settings.get("camera"), settings.get("rgbd", {})
    name = camera.get("preset") if isinstance(camera, dict) else camera
    if not isinstance(name, str) or name not in DEPTH_PRESETS or not isinstance(rgbd, dict) or "depth" in rgbd:
        return settings
    return settings | {"rgbd": rgbd | {"depth": name}}


def _mounted(kind: str, settings: tuple[Any, ...], mount: Mount, stream: str) -> MountedSensor:
    """Return one of the package's own sensors where a rig has it."""
    return MountedSensor(kind, SENSORS.get(kind)(*settings), mount, stream)
