"""Settings of a LiDAR, and real LiDARs by name, each with where its settings come from."""

from dataclasses import dataclass, field, replace
from math import ceil
from typing import Annotated, Any, ClassVar, Literal

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown, suggestion
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.sensors.lidar.finishes import BrightnessConfig
from warehouse_sim.sensors.lidar.lasers import LASERS

_MOST_RAYS = 1_000_000
"""Of one turn, four times an OS1-128's: a sweep needs some 200 bytes a ray."""
_DIMMEST = 20.0
"""Extinction times distance beyond which the power that comes back is 0 in single precision."""

_MOST_RETURNS = {"hdl64e": 2, "hdl64e_s2": 2, "vlp16": 2, "os1_128": 1, "safety2d": 1}
"""Of one pulse: two in the manuals of HDL-64E S2/S3 and VLP-16, one in the OS1's data sheet; SICK's is unknown."""
Model = Literal["hdl64e", "hdl64e_s2", "vlp16", "os1_128", "safety2d"]


@dataclass(frozen=True)
@ranged
class LidarConfig:
    """A LiDAR; in YAML also a preset's name, or ``model`` with what differs from that preset."""

    model: Model = "hdl64e"
    """Whose lasers: hdl64e, hdl64e_s2, vlp16, os1_128 or safety2d."""
    turns_per_second: Annotated[float, Range(0.1, 100, "1/s")] = 10.0
    """Turns of the head (1/s), 0.1-100."""
    azimuth_step_deg: Annotated[float, Range(0.01, 45, "deg")] = 0.1728
    """Angle between firing cycles (deg), 0.01-45; an HDL-64E fires every 48 us, so 0.1728 at 10 turns a second."""
    azimuth_range_deg: Annotated[tuple[float, float], Range(-180, 180, "deg")] = (-180.0, 180.0)
    """Least and largest azimuth (deg), 0 = forward, positive = left, within -180 to 180."""
    spin: Literal["counter_clockwise", "clockwise"] = "counter_clockwise"
    """Which way the head turns, seen from above: from the least azimuth to the largest, or the other way."""
    azimuth_phase: Literal["sampled", "fixed"] = "sampled"
    """Whether each sweep fires at other azimuths, by up to half a step, or all at the same, as an encoder says."""
    every_nth_beam: Annotated[int, Range(1, 128)] = 1
    """Keep each n-th beam from the top, 1-128."""
    min_range: Annotated[float, Range(0, 500, "m")] = 0.9
    """Nearest distance that is returned (m), 0-500."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 120.0
    """Farthest distance that is returned (m), > min_range, 0.01-500."""
    range_noise: Annotated[float, Range(0, 10, "m")] = 0.008
    """Standard deviation of the distance from pulse to pulse under a strong signal (m), 0-10."""
    laser_bias: Annotated[float, Range(0, 1, "m")] = 0.018
    """Standard deviation of the constant error of each laser of a unit (m), 0-1; none is beyond sqrt(3) of it."""
    range_noise_weak: Annotated[float, Range(0, 10, "m")] = 0.02
    """What a signal at the limit of detection adds to it, in squares (m), 0-10."""
    range_step: Annotated[float, Range(0, 10, "m")] = 0.002
    """Resolution of the distances (m), 0-10; 0 = continuous."""
    dark_range: Annotated[float, Range(0, 500, "m")] = 50.0
    """Where a surface of 10 % remission, seen straight on, is detected every second time (m), 0-500; 0 = no dropout."""
    extinction: Annotated[float, Range(0, 1, "1/m")] = 0.00235
    """Coefficient a of exp(-2 a R) (1/m), 0-1; with ``dark_range`` it says how far bright surfaces are seen."""
    detection_width: ClassVar[float] = 0.1
    """Over which fraction of the power at the limit detection sets in."""
    divergence_mrad: Annotated[tuple[float, float], Range(0, 100, "mrad")] = (2.0, 2.0)
    """Full angle of the beam, horizontal and vertical (mrad), 0-100; 0 and 0 = infinitely thin."""
    pulse_length: Annotated[float, Range(0, 100, "m")] = 0.75
    """Surfaces closer than this along the ray make one blended echo (m), 0-100; light travels it twice in a pulse."""
    returns: Literal["strongest", "last", "dual"] = "strongest"
    """Which echo of a pulse is reported: the strongest, the last, or both (if it is one, the second strongest)."""
    bloom_deg: Annotated[float, Range(0, 10, "deg")] = 0.4
    """Angle beside a retroreflector within which it shines as a surface of 10 % remission (deg), 0-10; 0 = none."""
    intensity_scale: Literal["linear", "diffuse100"] = "linear"
    """8 bit of 0-100 % remission (linear), or as the VLP-16: 0-100 of 255 for that, the rest for retroreflectors."""
    brightness: BrightnessConfig = field(default_factory=BrightnessConfig)
    """How the intensities of one material differ; ``even``: not at all."""
    film: bool = True
    """Whether stretch film sends echoes back and takes light from those behind it, or is not there at all."""
    motion: Literal["ignored", "raw", "deskewed"] = "raw"
    """Whether the vehicle's own motion bends the sweep, and whether points are put back to where it looked forward."""

    def __post_init__(self) -> None:
        first, last = self.azimuth_range_deg
        if first >= last:
            raise ValueError(f"azimuth_range_deg must rise, found {first}, {last}")
        if self.max_range <= self.min_range:
            raise ValueError(f"max_range must exceed min_range {self.min_range}, found {self.max_range}")
        if self.returns != "strongest" and _MOST_RETURNS[self.model] < 2:
            raise ValueError(
                f"returns must be strongest for {self.model}, which reports one echo; found {self.returns}"
            )
        if self.extinction * self.dark_range > _DIMMEST:
            raise ValueError(
                f"extinction x dark_range must be at most {_DIMMEST:g}, found {self.extinction * self.dark_range:g}: "
                "no light would come back from dark_range"
            )
        rays = self.rays_per_turn
        if rays > _MOST_RAYS:
            raise ValueError(f"azimuth_step_deg makes {rays:,} rays a turn, at most {_MOST_RAYS:,} are cast; raise it")

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "LidarConfig":
        """Read a preset's name, or settings over those of the preset that ``model`` names.

        Raises:
            ConfigError: Unknown preset or setting.
        """
        settings = {"model": data} if isinstance(data, str) else data
        name = settings.get("model", "hdl64e") if isinstance(settings, dict) else "hdl64e"
        if not isinstance(name, str) or name not in LIDAR_PRESETS:
            hint, known = suggestion(name, LIDAR_PRESETS), ", ".join(LIDAR_PRESETS)
            raise ConfigError(f"{where}: {shown(name)} is no LiDAR preset{hint}; known: {known}")
        if isinstance(settings, dict):
            preset, brightness = to_mapping(LIDAR_PRESETS[name]), settings.get("brightness")
            if isinstance(brightness, dict):
                settings = settings | {"brightness": preset["brightness"] | brightness}
            settings = preset | {key: value for key, value in settings.items() if key != "model"}
        return from_mapping(cls, settings, where)

    @property
    def rays_per_turn(self) -> int:
        """Rays of one sweep."""
        first, last = self.azimuth_range_deg
        lasers = len(LASERS[self.model]().elevation)
        return ceil((last - first) / self.azimuth_step_deg) * ceil(lasers / self.every_nth_beam)

    def ideal(self) -> "LidarConfig":
        """Return the same lasers without noise, dropout, steps, film or width of the beam, at the same azimuths."""
        errors = "range_noise laser_bias range_noise_weak range_step dark_range extinction bloom_deg"
        none: dict[str, Any] = dict.fromkeys(errors.split(), 0.0)
        even = BrightnessConfig.even()
        return replace(self, **none, divergence_mrad=(0.0, 0.0), azimuth_phase="fixed", brightness=even, film=False)


# Settings from data sheets, drivers and recordings; what is not said of a LiDAR is as the defaults, the HDL-64E's.

# HDL-64E: one sigma of 2 cm, 5 ns, 50 m at 10 % and 120 m at 80 % remission, as the header of BLenSor's model states
# them after the S2 data sheet; the extinction is what makes both ranges true. 2 mrad is the usual figure for its
# divergence. The 2 cm split as two KITTI sweeps do: 8 mm from pulse to pulse (fourth differences along rings, 7.3-8.2
# mm on the road), the rest, 18 mm, from laser to laser (17-28 mm between rings on upright planes, which are not all
# flat). KITTI's files run counter-clockwise. Blooming: no source, a prior.
_HDL64E: dict[str, Any] = {}
# VLP-16: "up to +-3 cm", 100 m, 6 ns, 55.296 us a cycle, 3 x 1.2 mrad, clockwise, two returns (user manual). All lasers
# of a unit are evenly spread over +-3 cm, which has a standard deviation of 17.3 mm; from pulse to pulse it is taken to
# be as good as the maker's HDL-64E. That the 100 m hold for 80 % remission, as other sheets say of theirs, is an
# assumption; 40 m at 10 % follow from it.
_VLP16: dict[str, Any] = dict(
    azimuth_step_deg=55.296e-6 * 10.0 * 360.0,
    spin="clockwise",
    max_range=100.0,
    laser_bias=0.0173,
    dark_range=40.7,
    divergence_mrad=(3.0, 1.2),
    pulse_length=0.9,
    intensity_scale="diffuse100",
)
# OS1-128 (data sheet): 2,048 columns, 0.8-120 m at 80 %, 40 m at 10 %, 1.5 cm (one sigma of repetitions) under a strong
# signal and 10 cm at a signal-to-noise ratio of 12, zero bias, steps of 1.2 cm, 0.18 deg full width at half maximum,
# one return. Its columns are places of the encoder; it turns clockwise (sensor documentation).
_OS1_128: dict[str, Any] = dict(
    azimuth_step_deg=360.0 / 2048.0,
    spin="clockwise",
    azimuth_phase="fixed",
    min_range=0.8,
    range_noise=0.015,
    laser_bias=0.0,
    range_noise_weak=0.1,
    range_step=0.012,
    dark_range=41.4,
    extinction=0.0,
    divergence_mrad=(3.14, 3.14),
)
# SICK's 270 deg scanner with flexible fields, part 1067299 (data sheet): 15 turns a second, 1 deg, 0.05-10 m, 8 m at
# 10 %, statistical error below 2 cm. Its telegrams run from -45 to +225 deg, counter-clockwise, in whole steps (TiM
# manuals). Its divergence and its constant error are not in the sheet; 10 mrad and 1 cm are assumptions.
_SAFETY2D: dict[str, Any] = dict(
    turns_per_second=15.0,
    azimuth_step_deg=1.0,
    azimuth_range_deg=(-135.0, 135.0),
    azimuth_phase="fixed",
    min_range=0.05,
    max_range=10.0,
    range_noise=0.02,
    laser_bias=0.01,
    range_step=0.001,
    dark_range=8.0,
    extinction=0.0,
    divergence_mrad=(10.0, 10.0),
)
# OS1-64 and OS1-32: the same optics and 45 deg with 64 and 32 evenly spaced channels (data sheets): every second and
# fourth beam of the 128.
_PRESETS = {
    "hdl64e": _HDL64E,
    "hdl64e_s2": {"model": "hdl64e_s2"} | _HDL64E,
    "vlp16": {"model": "vlp16"} | _VLP16,
    "os1_128": {"model": "os1_128"} | _OS1_128,
    "os1_64": {"model": "os1_128", "every_nth_beam": 2} | _OS1_128,
    "os1_32": {"model": "os1_128", "every_nth_beam": 4} | _OS1_128,
    "safety2d": {"model": "safety2d"} | _SAFETY2D,
}
"""What differs from the defaults, by the name of the preset; ``model`` says whose lasers it has."""
LIDAR_PRESETS = {name: LidarConfig(**changes) for name, changes in _PRESETS.items()}
"""Settings of real LiDARs by name."""
