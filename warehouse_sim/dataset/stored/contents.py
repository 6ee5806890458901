"""What a dataset holds, as its manifest says it: what formats, readers and checks know of it without its recipe."""

import re
from dataclasses import dataclass, field, fields
from typing import Annotated, Any

from warehouse_sim.config import to_mapping
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Lens, lens_of
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema.outputs import USUAL, Output, in_words

SENSOR_NAME = re.compile("[a-z][a-z0-9_]{0,60}")
"""Of what is stored in a folder of its name."""
_LIDAR_NAME = re.compile("[a-z][a-z0-9]{0,60}")
Amount = Annotated[float, Range(0, 1_000_000)]
Angle = Annotated[float, Range(-100_000, 100_000, "deg")]
Coefficient = Annotated[float, Range(-1_000_000, 1_000_000)]


@dataclass(frozen=True)
@ranged
class CameraContents:
    """A camera with its lens."""

    width: Annotated[int, Range(1, 65_535, "px")]
    height: Annotated[int, Range(1, 65_535, "px")]
    focal_px: Annotated[float, Range(0.001, 1_000_000, "px")]
    """Focal length along u (px)."""
    cx: Coefficient
    """Optical axis (px), as ``cy``."""
    cy: Coefficient
    distortion: Annotated[tuple[float, float, float, float, float], Range(-100, 100)] | None = None
    """k1, k2, p1, p2, k3 of the lens as in OpenCV; null = a pinhole or a fisheye."""
    fisheye: Annotated[tuple[float, float, float, float], Range(-10, 10)] | None = None
    """k1, k2, k3, k4 of a fisheye as in OpenCV; null = none."""
    focal_y_px: Annotated[float, Range(0.001, 1_000_000, "px")] | None = None
    """Focal length along v (px) where pixels are not square; null = that along u."""

    def to_plain(self) -> dict[str, Any]:
        """Return what is read back; the second focal length only where there is one."""
        plain = {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}
        return {name: value for name, value in plain.items() if name != "focal_y_px" or value is not None}

    @property
    def lens(self) -> Lens | None:
        """The lens; None where it does nothing."""
        coefficients = self.fisheye or self.distortion
        return None if coefficients is None else lens_of(coefficients)

    def make(self) -> PinholeCamera:
        """Return the camera."""
        focal_y_px = self.focal_px if self.focal_y_px is None else self.focal_y_px
        return PinholeCamera(self.width, self.height, self.focal_px, focal_y_px, self.cx, self.cy, self.lens)


@dataclass(frozen=True)
@ranged
class LidarContents:
    """How the main LiDAR stands and errs; all errors are zero where the recipe says nothing of them."""

    pitch_deg: Angle = 0.0
    """Of its mount, about the y axis (deg)."""
    roll_deg: Angle = 0.0
    """Of its mount, about the x axis (deg)."""
    range_noise: Amount = 0.0
    """Standard deviation of ranges at full signal (m)."""
    laser_bias: Amount = 0.0
    """Standard deviation of the constant errors of lasers (m); none is beyond sqrt(3) of it."""
    range_noise_weak: Amount = 0.0
    """Standard deviation that a signal of the relative power 1 adds (m); the weaker, the more."""
    range_step: Amount = 0.0
    """Ranges are multiples of this (m); 0 = not."""
    dark_range: Amount = 0.0
    """Distance at which a surface of remission 0.1 has the relative power 1 (m); 0 = power does not matter."""
    extinction: Annotated[float, Range(0, 10, "1/m")] = 0.0
    """Of the air (1/m)."""
    divergence_mrad: Annotated[tuple[float, float], Range(0, 1_000_000, "mrad")] = (0.0, 0.0)
    """Full angles of the beam (mrad)."""
    pulse_length: Amount = 0.0
    """Surfaces nearer together than this are mixed (m)."""
    intensity_scale: str = "linear"
    """How remission becomes intensity."""
    intensity_spread: Amount = 0.0
    """How far intensities are from the remission that a signal's strength goes with: a logarithm."""
    spin: str = "counter_clockwise"
    """Which way the head turns, seen from above: "clockwise" or another word for the other way."""
    motion: str = "ignored"
    """What the vehicle's motion does to a sweep: "ignored", "raw" or another word for put right."""
    turns_per_second: Annotated[float, Range(0.001, 1_000_000, "1/s")] = 10.0
    azimuth_step_deg: Annotated[float, Range(0.001, 360, "deg")] = 1.0
    azimuth_range_deg: Annotated[tuple[float, float], Range(-180, 180, "deg")] = (-180.0, 180.0)


@dataclass(frozen=True)
@ranged
class ChannelContents:
    """One array of a reading."""

    dtype: str
    """As numpy writes it, e.g. ``<f4``."""
    shape: tuple[Annotated[int, Range(0, 2_147_483_647)] | None, ...]
    """Length along each axis; null where it differs from observation to observation."""
    unit: str = ""
    """What the numbers are in, if the sensor says it."""


@dataclass(frozen=True)
class ReadingContents:
    """What a sensor that no format holds gives at each observation, stored under ``readings/``."""

    kind: str
    """Kind of the sensor, e.g. ``ultrasonic_ring``."""
    channels: dict[str, ChannelContents]
    """Its arrays by name."""


@dataclass(frozen=True)
@ranged
class Contents:
    """The sensors of a dataset and what else its files depend on; the default has a camera and a LiDAR."""

    name: str = ""
    """Name of the recipe."""
    description: str = ""
    """What the recipe says of itself."""
    channels: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """What formats hold of each sensor, by its name in the rig: "camera", "right", "lidar", ..."""
    camera: CameraContents | None = None
    """The camera of the labels; null where size and focal length are not known."""
    baseline: Annotated[float, Range(0.0001, 10_000, "m")] | None = None
    """From the left to the right camera (m); null = no right camera."""
    matched: bool = False
    """Whether the disparity that matching finds is stored."""
    clean: bool = False
    """Whether clean depth and colour are stored beside the readings."""
    left_out: tuple[Output, ...] = field(default=(), metadata={"omitted": True})
    """What the recipe wants no file of, though its rig has it."""
    codings: dict[Output, str] = field(default_factory=dict, metadata={"omitted": True})
    """Images of exact data that the recipe requires -> what their 16-bit PNGs say, see ``schema.outputs``."""
    lidar: LidarContents | None = field(default_factory=LidarContents)
    """The main LiDAR; null = none."""
    lidars: tuple[str, ...] = ()
    """Names of the LiDARs beside the main one; they are parts of folder names."""
    sensors: dict[str, str] = field(default_factory=dict)
    """Kinds of all other sensors by name."""
    readings: dict[str, ReadingContents] = field(default_factory=dict)
    """What those give; filled in at the end."""
    depth_ranges: dict[str, float] = field(default_factory=dict)
    """Largest depth that is read (m) by the recipe's setting, paired variants' included."""
    depth_bias: Annotated[float, Range(0, 1)] = 0.0
    """Most constant error that a depth camera of the recipe can have, as a fraction of depth."""
    tilted_viewpoints: tuple[str, ...] = ()
    """Kinds of viewpoints that may tilt the camera."""
    view_angle_deg: Annotated[float, Range(0, 180, "deg")] = 0.0
    """Largest angle to the horizon that the images of tilted cameras can reach (deg); 0 where none tilts."""
    levelled: tuple[str, ...] = ()
    """Formats that hold images, labels and calibration of a level virtual camera at the place of the tilted one: same
    heading, no lens, an image of its own size that shows all that the true one shows, rendered and never resampled."""
    targets: tuple[str, ...] | None = None
    """Class names that the recipe wants labelled; null where it does not say."""
    plugins: dict[str, str] = field(default_factory=dict)
    """Versions of the third-party packages that took part, by name."""

    def __post_init__(self) -> None:
        for name in self.lidars:
            if not _LIDAR_NAME.fullmatch(name):
                raise ValueError(f"the name of a LiDAR must be small letters and digits, found {shown(name)}")
        for name in (*self.sensors, *self.readings):
            if not SENSOR_NAME.fullmatch(name):
                raise ValueError(f"the name of a sensor must be small letters, digits and _, found {shown(name)}")

    @property
    def outputs(self) -> frozenset[Output]:
        """What the recipe wants of an observation, as far as its rig has it."""
        has: dict[Output, bool] = {
            "lidar": self.lidar is not None,
            "right": self.baseline is not None,
            "readings": bool(self.sensors),
        }
        usual = {name for name in USUAL if name not in self.left_out and has.get(name, True)}
        return frozenset(usual.union(("clean",) if self.clean else (), self.codings))

    def require(self, output: Output, root: object) -> None:
        """Reject to read what was left out.

        Raises:
            DatasetError: It was; says how the dataset at ``root`` would have it.
        """
        if output not in self.outputs:
            added = in_words({*self.outputs, output}).replace(",", "")
            raise DatasetError(f"{root}: holds no {output}; generate it with --outputs {added}")

    @property
    def distortion(self) -> Lens | None:
        """The camera's lens; None where it does nothing."""
        return None if self.camera is None else self.camera.lens
