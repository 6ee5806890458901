"""Settings of a LiDAR."""

from dataclasses import dataclass, field, replace
from math import ceil
from typing import Annotated, Any, ClassVar, Literal

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown, suggestion
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.sensors.lidar.finishes import BrightnessConfig
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.presets import MOST_RETURNS, PRESETS

_MOST_RAYS = 1_000_000
"""Of one turn, four times an OS1-128's: a sweep needs some 200 bytes a ray."""
_DIMMEST = 20.0
"""Extinction times distance beyond which the power that comes back is 0 in single precision."""

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
        if self.returns != "strongest" and MOST_RETURNS[self.model] < 2:
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


LIDAR_PRESETS = {name: LidarConfig(**changes) for name, changes in PRESETS.items()}
"""Settings of real LiDARs by name."""
