"""What sensors read: every reading is a set of named arrays, whatever else it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from jaxtyping import Bool, Float32, Int32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform


@dataclass(frozen=True, eq=False)
class NominalCalibration:
    """The calibration of one observation that an estimator gets; images and labels are those of the true one."""

    camera: PinholeCamera
    """Intrinsics and lens of the rig's camera."""
    depth_factor: float = 1.0
    """Metres that are said to be one metre of the depth image as it is stored."""
    T_camera_sensor: Mapping[str, Transform] = field(default_factory=dict)
    """Pose in the camera frame of each sensor that is calibrated to it, by name; what its clock errs is in it."""
    time_offset: Mapping[str, float] = field(default_factory=dict)
    """How much later than the camera's moment each of them is said to have read, though it read then (s)."""


Channels = Mapping[str, np.ndarray[Any, Any]]
"""Arrays of numbers by name."""
CAMERA, LIDAR, RIGHT, IMU = "camera", "lidar", "right", "imu"
"""Names in a rig of the camera that labels are made for, of the main LiDAR, the second camera and the inertial unit."""


class Reading(Protocol):
    """What a sensor read at one moment."""

    @property
    def channels(self) -> Channels:
        """All that a sensor of this kind would give, the simulation's ground truth left out, as arrays by name."""


def units_of(reading: Reading) -> Mapping[str, str]:
    """Return what the numbers of a reading's channels are in, by channel; a reading need not state any as ``units``."""
    stated: Mapping[str, str] = getattr(reading, "units", {})
    return stated


AnyReading = TypeVar("AnyReading", bound=Reading, covariant=True)


@dataclass(frozen=True, eq=False)
class MountedReading(Generic[AnyReading]):
    """A reading, and where its sensor was."""

    T_camera_sensor: Transform
    """Pose of the sensor's own frame in the frame of the rig's camera."""
    reading: AnyReading


@dataclass(frozen=True, eq=False)
class ChannelReading:
    """The reading of a sensor that no other class here fits."""

    channels: Channels
    """Arrays by name; the sensor's description says what they mean."""
    units: Mapping[str, str] = field(default_factory=dict)
    """What the numbers of a channel are in ("m"), where that is known."""


NO_COLOR: UInt8[np.ndarray, "h w 3"] = np.zeros((0, 0, 3), np.uint8)
"""Stands for an image that was not made: nothing can be taken from it."""


@dataclass(frozen=True, eq=False)
class RenderBuffers:
    """What a renderer returns for one camera; all channels share the same pixel centres."""

    rgb: UInt8[np.ndarray, "h w 3"]
    """``NO_COLOR`` where none was drawn."""
    depth: Float32[np.ndarray, "h w"]
    """Metres along the optical axis, 0 = nothing."""
    instance_mask: Int32[np.ndarray, "h w"]
    """0 = background."""
    normals: Float32[np.ndarray, "h w 3"] | None = None
    """Unit surface normals in the camera frame, zero on the background."""


@dataclass(frozen=True, eq=False)
class RgbdReading:
    """An image and the depth a real camera would give for it."""

    rgb: UInt8[np.ndarray, "h w 3"]
    """``NO_COLOR`` where no image was wanted."""
    depth: Float32[np.ndarray, "h w"]
    """Metres along the optical axis with the sensor's noise, 0 = no reading."""

    @property
    def channels(self) -> Channels:
        """Colour and depth."""
        return {"rgb": self.rgb, "depth": self.depth}


@dataclass(frozen=True, eq=False)
class LidarScan:
    """One sweep; only returns, in firing order."""

    points: Float32[np.ndarray, "n 3"]
    """LiDAR frame (m)."""
    intensity: Float32[np.ndarray, " n"]
    """Reflected share, 0-1."""
    instance_ids: Int32[np.ndarray, " n"]
    ring: Int32[np.ndarray, " n"]
    """Beam number, 0 = topmost."""
    time: Float32[np.ndarray, " n"]
    """When the point was measured, since the sweep began (s)."""

    @property
    def channels(self) -> Channels:
        """Points with what the sensor tells of each; not of which object they are."""
        return {"points": self.points, "intensity": self.intensity, "ring": self.ring, "time": self.time}


@dataclass(frozen=True, eq=False)
class StereoReading:
    """What a second camera adds, parallel to the first and on its right."""

    baseline: float
    """Distance of the optical centres (m)."""
    rgb: UInt8[np.ndarray, "h w 3"]
    """The right image as read."""
    buffers: RenderBuffers
    """The clean ground truth behind it."""
    disparity: Float32[np.ndarray, "h w"]
    """True disparity of the left image, f b / z (px), 0 = nothing there."""
    in_both: Bool[np.ndarray, "h w"]
    """Pixels of the left image whose surface the right camera sees, too."""
    matched: Float32[np.ndarray, "h w"] | None = None
    """Disparity that matching the two images as read gives (px), 0 = none."""

    @property
    def channels(self) -> Channels:
        """The right image, and the disparity where it is matched."""
        return {"rgb": self.rgb} | ({} if self.matched is None else {"disparity": self.matched})
