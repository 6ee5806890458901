"""Settings of a colour camera."""

from dataclasses import dataclass
from typing import Annotated, Any

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, Share, ranged


@dataclass(frozen=True)
@ranged
class ColorConfig:
    """Light and errors of a colour camera; in YAML also ``ideal``, which reads the clean image."""

    shot_noise: Annotated[float, Range(0, 1)] = 0.0001
    """Variance of linear light (1 = saturation) per linear value at ISO 100, 0-1; 1 / full well in electrons."""
    read_noise: Annotated[float, Range(0, 1)] = 0.00000002
    """Variance of linear light that is always there, at ISO 100, 0-1."""
    noise_scale: Annotated[float, Range(0, 100)] = 1.0
    """Factor on the standard deviation of both, 0-100."""
    f_number: Annotated[float, Range(0.5, 100)] = 2.0
    """Focal length over aperture, 0.5-100."""
    max_shutter_ms: Annotated[float, Range(0.001, 10_000, "ms")] = 10.0
    """Longest exposure (ms), 0.001-10,000; where it is too short for the scene, the gain rises."""
    exposure_error: Annotated[float, Range(0, 10, "stops")] = 0.1
    """Standard deviation of an image's exposure (stops), 0-10."""
    white_balance_error: Share = 0.015
    """Standard deviation of the gains of red and blue, relative, 0-1."""
    vignetting: Share = 0.2
    """Share of the natural falloff cos^4 that the lens and its correction leave, 0-1."""
    motion_blur: bool = True
    """Whether what moves in the image while the shutter is open is blurred."""
    bayer: bool = False
    """Whether each pixel sees one colour only, and the others are interpolated."""
    jpeg_quality: Annotated[int, Range(1, 100)] | None = None
    """Quality at which the image was compressed, 1-100; null = it was not."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "ColorConfig":
        """Read the name ``ideal`` or a mapping of settings.

        Raises:
            ConfigError: Unknown name or setting.
        """
        if not isinstance(data, str):
            return from_mapping(cls, data, where)
        if data != "ideal":
            raise ConfigError(f"{where}: {shown(data)} is no colour camera; known: ideal")
        return IDEAL_COLOR

    def shutter_and_gain(self, exposure_ev: float | None) -> tuple[float, float]:
        """Return for how long the shutter is open (s), and the gain over ISO 100.

        ``2^EV = N^2 / t`` at ISO 100 (ISO 2720): a darker scene gets a longer time, and then a higher gain.

        Args:
            exposure_ev: Exposure value at ISO 100; None = enough light for the longest time at ISO 100.
        """
        longest = self.max_shutter_ms / 1000.0
        if exposure_ev is None:
            return longest, 1.0
        wanted = self.f_number**2 / 2.0**exposure_ev
        return min(wanted, longest), max(wanted / longest, 1.0)


IDEAL_COLOR = ColorConfig(
    noise_scale=0.0, exposure_error=0.0, white_balance_error=0.0, vignetting=0.0, motion_blur=False
)
"""A camera that reads the clean image."""
