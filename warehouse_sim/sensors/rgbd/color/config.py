"""Settings of a colour camera."""

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Fraction, Range, ranged


@dataclass(frozen=True)
@ranged
class ColorConfig:
    """Light and errors of a colour camera that stores a developed image; in YAML also the name of a preset.

    ``ideal`` reads the clean image, ``raw`` is a machine camera that stores the mosaic interpolated and nothing more,
    ``phone`` smooths, sharpens and reads row by row, ``plain`` has noise and vignetting alone.
    """

    shot_noise: ClassVar[float] = 0.0001
    """Variance of linear light (1 = saturation) per linear value at ISO 100; 1 / full well in electrons.

    Machine cameras with pixels of 3.45 um have a full well of 10,700 electrons and a dynamic range of 75 dB: about two
    electrons of noise (Sony IMX250 in Teledyne DALSA's manual of the Genie Nano M2450).
    """
    read_noise: ClassVar[float] = 0.00000002
    """Variance of linear light that is always there, at ISO 100."""
    noise_scale: Annotated[float, Range(0, 100)] = 1.0
    """Factor on the standard deviation of both, 0-100."""
    f_number: ClassVar[float] = 2.0
    """Focal length over aperture."""
    max_shutter_ms: Annotated[float, Range(0.001, 10_000, "ms")] = 10.0
    """Longest exposure (ms), 0.001-10,000; where it is too short for the scene, the gain rises."""
    exposure_error: Annotated[float, Range(0, 10, "stops")] = 0.1
    """Standard deviation of an image's exposure (stops), 0-10."""
    auto_white_balance: Fraction = 0.8
    """Fraction of the cast of the light in view that the camera takes away, 0-1. No source: a prior."""
    white_balance_error: Fraction = 0.015
    """Standard deviation of the gains of red and blue, relative, 0-1."""
    vignetting: Fraction = 0.2
    """Fraction of the natural falloff cos^4 that the lens and its correction leave, 0-1."""
    motion_blur: bool = True
    """Whether what moves in the image while the shutter is open is blurred."""
    rolling_shutter_ms: Annotated[float, Range(0, 1000, "ms")] = 0.0
    """Time from the first row's exposure to the last one's (ms), 0-1,000; the middle row is taken at the observation's
    time. 0 = a global shutter."""
    blur_px: Annotated[float, Range(0, 10, "px")] = 0.4
    """Standard deviation of the point spread of lens and pixel (px), 0-10."""
    glare: Fraction = 0.02
    """Fraction of the light that lens and housing scatter over the image, 0-1."""
    flicker: Fraction = 0.08
    """Depth of modulation of the light on the mains, 0-1; exposures of whole periods do not see it."""
    flicker_hz: ClassVar[float] = 100.0
    """Frequency of that (Hz): twice that of the mains."""
    saturation: Annotated[float, Range(0.1, 8)] = 1.0
    """Linear light at which a pixel is full, 0.1-8: stored as white. Above 7.2 the display curve saturates first."""
    bits: Annotated[int, Range(8, 16)] = 10
    """Bits of a pixel's number, 8-16."""
    black_level: Annotated[float, Range(0, 0.5)] = 0.0625
    """Fraction of the numbers that lies below black and keeps the lower half of the noise, 0-0.5."""
    red_gain: Annotated[float, Range(1, 8)] = 2.0
    """Amplification of red, after the noise, that makes white white, 1-8."""
    blue_gain: Annotated[float, Range(1, 8)] = 1.7
    """Amplification of blue, 1-8."""
    bayer: bool = True
    """Whether each pixel sees one colour only, and the others are interpolated."""
    denoise: Annotated[float, Range(0, 10)] = 0.25
    """Fine detail that is taken for noise and removed at ISO 100, in standard deviations of the noise of a mid grey,
    0-10; more at a higher gain, see ``denoise_at``."""
    sharpen: Annotated[float, Range(0, 4)] = 0.1
    """Fraction of the remaining fine detail that is added once more, 0-4."""
    jpeg_quality: Annotated[int, Range(1, 100)] | None = 90
    """Quality at which the image was compressed, 1-100; null = it was not."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "ColorConfig":
        """Read the name of a preset, or a mapping of settings.

        A mapping may hold ``preset`` and settings that replace its own.

        Raises:
            ConfigError: Unknown name or setting.
        """
        if isinstance(data, dict) and "preset" in data:
            settings = {key: value for key, value in data.items() if key != "preset"}
            preset = cls.from_plain(data["preset"], f"{where}: preset")
            changed = from_mapping(cls, settings, where)
            return replace(preset, **{name: getattr(changed, name) for name in settings})
        if not isinstance(data, str):
            return from_mapping(cls, data, where)
        if data not in COLOR_PRESETS:
            raise ConfigError(f"{where}: {shown(data)} is no colour camera; known: {', '.join(COLOR_PRESETS)}")
        return COLOR_PRESETS[data]

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

    def denoise_at(self, gain: float) -> float:
        """Return ``denoise`` at a gain over ISO 100: it grows with the fourth root, to twice as much at ISO 1600.

        Processors of cameras take the strength of noise removal from tables over ISO (``hi_isp_nr_auto_attr`` of
        HiSilicon's ISP API has 16 steps). It ends at 3.2 standard deviations, which ``rpi.denoise`` of Raspberry Pi's
        libcamera takes for noise by default. The root has no source: a prior.
        """
        return min(self.denoise * gain**0.25, max(_MOST_REMOVED, self.denoise))


_MOST_REMOVED = 3.2
_UNDEVELOPED = ColorConfig(auto_white_balance=0.0, bits=12, denoise=0.0, sharpen=0.0, jpeg_quality=None)
# Small pixels read row by row, and much development. Practical prior.
_PHONE = ColorConfig(
    noise_scale=1.6, exposure_error=0.2, rolling_shutter_ms=20.0, vignetting=0.3, denoise=0.6, sharpen=0.3
)
_PLAIN = replace(
    _UNDEVELOPED,
    blur_px=0.0,
    glare=0.0,
    flicker=0.0,
    saturation=8.0,
    bits=16,
    black_level=0.0,
    red_gain=1.0,
    blue_gain=1.0,
    bayer=False,
)
IDEAL_COLOR = replace(
    _PLAIN, noise_scale=0.0, exposure_error=0.0, white_balance_error=0.0, vignetting=0.0, motion_blur=False
)
"""A camera that reads the clean image."""
COLOR_PRESETS = {"ideal": IDEAL_COLOR, "phone": _PHONE, "plain": _PLAIN, "raw": _UNDEVELOPED}
"""Colour cameras by the name that a recipe may give."""
