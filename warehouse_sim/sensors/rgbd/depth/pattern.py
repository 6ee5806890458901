"""How clearly a camera sees a pattern: dots and texture against the noise of its images, and dots where film is.

Light is in lux on white: the illuminance of white plaster by white light that gives as many electrons. Images are
halved, as materials are known for every second pixel only. The numbers that have no source are priors: a projector of a
quarter of a watt over 90 x 60 degrees, imagers of three micrometres that aim at a third of their range.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.film import FilmImage
from warehouse_sim.sensors.pixel_rays import pixel_tangents
from warehouse_sim.sensors.rgbd.color.pixels import linear_light

Image = Float32[np.ndarray, "h w"]
_STREAM = 0x756E6974
"""Of all draws of units."""


@dataclass(frozen=True)
class StereoUnit:
    """Of one triangulating camera."""

    scale: float
    """By which all depths are too large, as a fraction."""
    bow: float
    """Disparity at the corners less that at the middle (px of the sensor), as the square of the distance grows."""
    tilt: float
    """Disparity at the right border less that at the left (px of the sensor)."""
    shift_uv: tuple[float, float]
    """By how much depth is registered beside colour (px of the image)."""

    @classmethod
    def sample(cls, unit: int, scale: float, bow_px: float, registration_px: float) -> "StereoUnit":
        """Return the camera of a number; numbers draw from a stream of their own.

        Args:
            unit: Its number.
            scale: Standard deviation of ``scale``.
            bow_px: That of ``bow`` and of ``tilt``.
            registration_px: That of each of ``shift_uv``.
        """
        sampled = np.random.default_rng([_STREAM, unit]).standard_normal(5)
        return cls(scale * sampled[0], bow_px * sampled[1], bow_px * sampled[2],
                   (registration_px * sampled[3], registration_px * sampled[4]))  # fmt: skip

    def offset(self, camera: PinholeCamera) -> Float32[np.ndarray, "h w"]:
        """Return the error of disparity at each pixel (px of the sensor), zero on average over the image."""
        x, y = pixel_tangents(camera)
        corner = np.float32(self.bow / max(float(np.square(x).max() + np.square(y).max()), 1e-9))
        across = corner * np.square(x) + np.float32(self.tilt / max(float(np.ptp(x)), 1e-9)) * x
        down = corner * np.square(y)
        return (across - across.mean()) + (down - down.mean())


def shifted(image: np.ndarray, shift_uv: tuple[float, float]) -> np.ndarray:
    """Return an image whose pixels have moved by whole pixels, its border repeated.

    Args:
        image: Of any kind.
        shift_uv: By how much (px), rounded.
    """
    right, down = (round(value) for value in shift_uv)
    if right == down == 0:
        return image
    height, width = image.shape[:2]
    moved = cv2.copyMakeBorder(image, max(down, 0), max(-down, 0), max(right, 0), max(-right, 0), cv2.BORDER_REPLICATE)
    return moved[max(-down, 0) :, max(-right, 0) :][:height, :width]


_SATURATION = 1.2
"""Luminance (cd/m^2) of a linear image value of 1 at an exposure value of 0 (ISO 100)."""
_USUAL_EV = 7.3
"""Exposure value where none is stated: white in 300 lx is half of what the image holds."""
_DOT_SLOPE = 0.18
"""Root mean square of the slope of the dots' light (1 / px) where the middle of a dot is 1: Gaussians of 0.84 px that
are 4.5 px apart. No source."""
_DOT_FRACTION = 0.14
"""Mean of the dots' light where the middle of a dot is 1. No source."""
_ELECTRONS = 3500.0
"""Mean of an image that the exposure aims at. No source."""
_ELECTRONS_PER_LUX = 33.0
"""On white, at the longest exposure. No source."""
_READ_NOISE = 7.5
"""Electrons, with the steps of the 8-bit image. No source."""


def halved(image: np.ndarray) -> np.ndarray:
    """Return every second pixel of every second row, as an array of its own."""
    return np.ascontiguousarray(image[::2, ::2])


def doubled(image: np.ndarray, size_hw: tuple[int, int], how: int = cv2.INTER_LINEAR) -> np.ndarray:
    """Return a halved image at full size.

    Args:
        image: Of one channel.
        size_hw: Of the result.
        how: OpenCV's way to interpolate.
    """
    height, width = size_hw
    return cv2.resize(image, (2 * image.shape[1], 2 * image.shape[0]), interpolation=how)[:height, :width]


def hall_light(rgb: UInt8[np.ndarray, "h w 3"], exposure_ev: float | None) -> Image:
    """Return the hall's light that surfaces send back (lux on white), of every second row.

    The imagers have no filter for infrared alone, and see about what the colour camera sees.

    Args:
        rgb: The clean colour image.
        exposure_ev: What it was exposed for; None = enough light.
    """
    ev = _USUAL_EV if exposure_ev is None else exposure_ev
    shown = linear_light(cv2.cvtColor(np.ascontiguousarray(rgb[::2]), cv2.COLOR_RGB2GRAY))
    return shown * np.float32(np.pi * _SATURATION * 2.0**ev)


def texture_slope(light: Image, window_px: int) -> Image:
    """Return the root mean square of the light's slope along rows in windows (lux per image pixel), halved.

    Args:
        light: Of the hall (lux on white), of every second row.
        window_px: Edge of the window (image pixels).
    """
    slope = cv2.Sobel(light, cv2.CV_32F, 1, 0, ksize=1, scale=0.5)
    square = np.square(slope)
    size = (-(-light.shape[1] // 2), square.shape[0])
    small = cv2.resize(square, size, interpolation=cv2.INTER_AREA)
    half = max(round(window_px / 2), 1) | 1
    mean: Image = np.sqrt(np.maximum(cv2.blur(small, (half, half)), np.float32(0.0)))
    return mean


def clarity(hall: Image, dots: Image, texture: Image) -> tuple[Image, Image]:
    """Return slopes over noise in the infrared images (1 / px), and the fraction of the slopes' power that is dots.

    Noise is that of electrons and of reading them; the exposure is one for the image.

    Args:
        hall: Light of the hall that comes back (lux on white).
        dots: That of a dot's middle (lux on white).
        texture: Slope of the hall's light (lux on white per pixel of the imagers).
    """
    light = hall + np.float32(_DOT_FRACTION) * dots
    sample = light[::4, ::4]
    # What is far too bright is clipped, and moves the exposure no further.
    mean = float(np.minimum(sample, np.float32(2.0) * np.median(sample)).mean())
    per_lux = min(_ELECTRONS / max(mean, 1e-6), _ELECTRONS_PER_LUX)
    noise = light / np.float32(per_lux) + np.float32((_READ_NOISE / per_lux) ** 2)
    by_dots = np.square(np.float32(_DOT_SLOPE) * dots)
    slope = by_dots + np.square(texture) + np.float32(1e-9)
    return np.sqrt(slope / noise), by_dots / slope


_GLINT_PX = 0.6
"""Standard deviation of disparity (px of the sensor) where all light is mirrored by wrinkles, whose highlights lie
elsewhere for each eye; no source: a prior."""


@dataclass(frozen=True, eq=False)
class FilmedDots:
    """What can be matched of two patterns, one over the other."""

    dots: Image
    """Light of the stronger pattern."""
    on_film: Bool[np.ndarray, "h w"]
    """Where that lies on the film."""
    rival: Image
    """Light of the weaker pattern as a fraction of the stronger one's, where the two lie at least 1 px apart."""
    glint: Image
    """Fraction of the light that wrinkles mirror."""

    @classmethod
    def of(cls, dots: Image, depth: Image, film: FilmImage, ragged: Image, lux: float, unit: float) -> "FilmedDots":
        """Return what is seen of the dots.

        Args:
            dots: Light of those on what is solid, without film.
            depth: Of what is solid (m).
            film: Before it.
            ragged: Factor on the film's light where the patterns compete: borders of patches are not straight.
            lux: Light of a dot on white plaster that faces the projector from 1 m, in units of ``dots``.
            unit: Focal length times baseline (px m).
        """
        # Light that is turned aside on the way shows no dots.
        behind = dots * np.square(film.passed * film.clear)
        front = np.float32(lux) * film.light / np.square(film.depth)
        on_film = front * ragged > behind
        stronger = np.where(on_film, front, behind)
        apart = np.where(front > 0, np.float32(unit) * (1 / film.depth - 1 / np.maximum(depth, np.float32(0.01))), 0)
        both = np.maximum(front + behind, np.float32(1e-9))
        return cls(
            dots=stronger,
            on_film=on_film,
            rival=(both - stronger) / np.maximum(stronger, np.float32(1e-9)) * np.minimum(np.abs(apart), 1),
            glint=np.float32(lux) * film.glossy / np.square(film.depth) / both,
        )

    def variance(self, blurred_px: float) -> Image:
        """Return what film adds to the variance of disparity (px^2 of the sensor).

        Args:
            blurred_px: Standard deviation where a pattern is as strong as the noise, here that of its rival.
        """
        rival = np.float32(blurred_px**2) * np.square(np.minimum(self.rival, 2))
        return np.asarray(rival + np.float32(_GLINT_PX**2) * np.square(self.glint), np.float32)
