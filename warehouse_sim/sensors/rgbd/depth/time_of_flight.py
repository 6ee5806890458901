"""A camera that measures the phase of modulated light in each pixel."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, ClassVar

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.film import FilmImage
from warehouse_sim.sensors.pixel_rays import pixel_tangents
from warehouse_sim.sensors.rgbd.depth.model import Depth, LitDepth
from warehouse_sim.sensors.rgbd.depth.multipath import added, gathered, multipath_bias, read_off, scattered
from warehouse_sim.sensors.rgbd.depth.noise import (
    gaussian_noise,
    odd_window,
    unit_noise,
    unit_pattern,
    unit_samples,
    wiggle,
)
from warehouse_sim.sensors.surfaces import facing_cosine, returned_by_retroreflectors, returned_light
from warehouse_sim.sensors.view import Capture

_SATURATED = 1e3
"""Light beyond which more of it does not help (white plaster facing the emitter from 1 m gives 1)."""


_NEAREST = np.float32(1e-6)
"""Keeps quotients finite where there is nothing, and so no light either."""


@dataclass(frozen=True)
@ranged
class TimeOfFlight(LitDepth):
    """Noise by range, angle and reflectance; flying pixels at edges; longer ranges in corners.

    The noise is that of Cai et al. 2024, "Noise analysis and modeling of the PMD Flexx2 depth camera for robotic
    applications" (arXiv 2412.15040), measured on white; the defaults are its mode 5 at 30 frames a second. On darker
    surfaces it grows as 1 / sqrt(reflectance), as shot noise of the emitter's own light does (Lange & Seitz 2001,
    "Solid-state time-of-flight range camera").
    """

    kind: ClassVar[str] = "time_of_flight"
    needs_normals: ClassVar[bool] = True
    needs_color: ClassVar[bool] = False
    needs_surfaces: ClassVar[bool] = True

    min_range: Annotated[float, Range(0, 500, "m")] = 0.1
    """Nearest depth that is read (m), 0-500."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 2.4
    """Farthest depth that is read (m), > min_range, 0.01-500; 2.4 is that of the Flexx2's mode 5."""
    sigma_base: Annotated[float, Range(0, 10, "m")] = 0.002362
    """Standard deviation at z = 0 (m), 0-10."""
    sigma_linear: Annotated[float, Range(-10, 10)] = -0.001041
    """Its growth with depth (m/m), -10 to 10."""
    sigma_square: Annotated[float, Range(0, 10, "1/m")] = 0.000753
    """Its growth with the square of depth (1/m), 0-10."""
    sigma_angle: Annotated[float, Range(0, 10)] = 0.000185
    """Its growth with z^2.7 theta^2 / (pi/2 - theta)^2, theta the angle of incidence, 0-10."""
    sigma_lateral_px: Annotated[float, Range(0, 20, "px")] = 0.864
    """Standard deviation of the spot that a pixel gathers light from (px of the sensor), 0-20."""
    focal_px: Annotated[float, Range(50, 20_000, "px")] = 210.6
    """Focal length of the sensor itself (px), 50-20,000: 56 degrees over 224 px."""
    unambiguous_range: ClassVar[float] = 7.5
    """Range at which the phase, put together from all frequencies, starts again (m)."""
    min_coherence: Fraction = 0.6
    """Least length of the sum of phases in a pixel's spot, relative to the sum of their lengths, 0-1."""
    min_signal: Annotated[float, Range(0, 1000)] = 0.0005
    """Least light of the emitter that must come back, 0-1,000; white plaster facing it from 1 m gives 1."""
    max_signal: ClassVar[float] = 10.0
    """Most light that pixels take from retroreflectors in the measure of ``min_signal``; beyond it
    they are saturated and read nothing. No source: a prior."""
    lamp_offset: ClassVar[float] = 0.025
    """From the emitter to the lens (m) that retroreflectors are seen by. No source: a prior."""
    max_sigma: ClassVar[float] = 0.1
    """Readings of a larger standard deviation are dropped, as confidence filters do (m)."""
    multipath: Fraction = 1.0
    """Fraction of the light by way of other surfaces that is not compensated, 0-1."""

    smooth_px: Annotated[float, Range(0, 20, "px")] = 0.0
    """Standard deviation of the filter that the camera smooths its errors with (px of the sensor), 0-20; 0 = none."""
    fixed_pattern: Annotated[float, Range(0, 1)] = 0.0
    """Standard deviation of the constant error of each pixel of a unit, as a fraction of depth, 0-1."""
    unit_offset: Annotated[float, Range(0, 1, "m")] = 0.0
    """Standard deviation of the constant error of units (m), 0-1."""
    unit_scale: Annotated[float, Range(0, 0.2)] = 0.0
    """Standard deviation of the error of units that grows with depth, as a fraction of it, 0-0.2."""
    wiggle: Annotated[float, Range(0, 1, "m")] = 0.0
    """Amplitude of the cyclic error, whose phase is the unit's (m), 0-1."""
    stray_light: Fraction = 0.0
    """Fraction of the image's light that lens and sensor spread evenly over all pixels, 0-1."""
    gloss_bias: Annotated[float, Range(-1, 1, "m")] = 0.0
    """How much farther a return seems that is gloss alone (m), -1 to 1: highlights drive pixels out of their range."""
    reflections: Fraction = 0.0
    """Fraction of the light by way of smooth surfaces, such as wet floors, that is followed, 0-1."""
    film_glare: ClassVar[float] = 8.0
    """Most light that wrinkles of film may mirror back, relative to white plaster at the same place:
    more drives pixels out of their range. No source."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sigma_linear < 0 and self.sigma_linear**2 >= 4.0 * self.sigma_base * self.sigma_square:
            raise ValueError(f"sigma_linear makes the noise negative at some range, found {self.sigma_linear}")

    @property
    def needs_reflections(self) -> bool:
        """Whether ``Surfaces.reflected`` must be filled."""
        return self.reflections > 0

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none."""
        assert buffers.normals is not None
        assert capture.surfaces is not None
        camera, depth = capture.camera, buffers.depth
        cosine = facing_cosine(buffers.normals, camera)
        diffuse, glossy = returned_light(capture.surfaces, cosine)
        white = np.clip(capture.surfaces.remission, np.float32(0.01), np.float32(1.0))
        if self.needs_reflections:
            kept = self._kept(capture)
            diffuse, white = diffuse * kept, np.maximum(white * kept, np.float32(0.01))
        film = None if capture.film is None or not self.film else capture.film.whole(depth)
        if film is not None:
            through = np.square(film.passed)
            diffuse, glossy = diffuse * through, glossy * through
            white = np.clip(white * through + film.light, np.float32(0.01), np.float32(1.0))
        light = diffuse + glossy
        mirrored = returned_by_retroreflectors(capture.surfaces.remission, cosine, depth, self.lamp_offset)
        if mirrored is not None:
            mirrored = mirrored if film is None else mirrored * through
            light = np.where(mirrored > 0, mirrored, light)
        # Materials are seen coarser than depth: beside an outline they are those of the thing, where nothing is.
        signal = np.divide(light, depth * depth, out=np.zeros_like(depth), where=depth > 0)
        mixed, clear, signal = self._mixed(depth, np.minimum(signal, np.float32(_SATURATED)), capture, film)
        if mirrored is not None:
            clear &= ~self._saturated(mirrored, depth, capture.camera)
        if film is not None:
            clear &= film.glossy <= np.float32(self.film_glare)
            glossy, light = glossy + film.glossy, light + film.light
        if self.multipath > 0:
            longer = multipath_bias(depth, buffers.normals, capture.surfaces.remission, camera)
            longer *= cosine_of_view(camera)
            longer *= np.float32(self.multipath)
            mixed += longer
        if self.gloss_bias != 0:
            mixed += np.float32(self.gloss_bias) * glossy / np.maximum(light, _NEAREST)
        theta = np.arccos(np.clip(cosine, np.float32(0.05), np.float32(1.0))) if self.sigma_angle > 0 else cosine
        sigma = self.axial_sigma(depth, theta)
        sigma *= np.float32(self.noise_scale)
        sigma /= np.sqrt(white)
        read = self._noise((depth.shape[0], depth.shape[1]), rng, camera.fx / self.focal_px)
        read *= sigma
        read += mixed
        read += self._of_the_unit(mixed, camera.fx / self.focal_px)
        clear &= (signal >= np.float32(self.min_signal)) & (sigma <= np.float32(self.max_sigma))
        return np.where(clear, read, np.float32(0.0))

    def axial_sigma(self, z: Float[np.ndarray, "*s"], theta: Float[np.ndarray, "*s"]) -> Float[np.ndarray, "*s"]:
        """Return the standard deviation of depth (m) on white, from z (m) and the angle of incidence (rad)."""
        straight = np.float32(self.sigma_base) + z * (np.float32(self.sigma_linear) + np.float32(self.sigma_square) * z)
        if self.sigma_angle == 0:
            return straight
        lean = theta / (np.float32(np.pi / 2) - theta)
        return straight + np.float32(self.sigma_angle) * z ** np.float32(2.7) * lean * lean

    def _noise(self, size_hw: tuple[int, int], rng: np.random.Generator, scale: float) -> Depth:
        """Return noise of variance 1; pixels of the image that lie on one pixel of the sensor have it in common."""
        if self.smooth_px > 0:
            return gaussian_noise(size_hw, rng, self.smooth_px * scale)
        return unit_noise(size_hw, rng, odd_window(scale))

    def _of_the_unit(self, depth: Depth, scale: float) -> Depth | np.float32:
        """Return the constant error of the unit at each pixel (m)."""
        offset, growth, phase = unit_samples(self.built)
        error: Depth | np.float32 = np.float32(self.unit_offset * offset)
        if self.unit_scale > 0:
            error = error + np.float32(self.unit_scale * growth) * depth
        if self.fixed_pattern > 0:
            size = (depth.shape[0], depth.shape[1])
            pattern = unit_pattern(self.built, size, max(self.smooth_px, 0.5) * scale)
            error = error + np.float32(self.fixed_pattern) * depth * pattern
        if self.wiggle > 0:
            error = error + np.float32(self.wiggle) * wiggle(depth, self.unambiguous_range, phase)
        return error

    def _saturated(self, mirrored: Depth, depth: Depth, camera: PinholeCamera) -> Bool[np.ndarray, "h w"]:
        """Return the pixels that light of retroreflectors floods; it spreads over the spot of each pixel."""
        signal = mirrored / np.square(np.maximum(depth, _NEAREST))
        spot = self.sigma_lateral_px * camera.fx / self.focal_px
        flooded = gathered(signal, spot) if spot > 0 else signal
        return np.asarray(flooded > np.float32(self.max_signal))

    def _kept(self, capture: Capture) -> Depth:
        """Return the fraction of diffuse light that smooth surfaces send back."""
        assert capture.surfaces is not None
        assert capture.surfaces.reflected is not None
        lost = np.float32(self.reflections) * (np.float32(1.0) - capture.surfaces.reflected.kept)
        return np.asarray(np.float32(1.0) - lost)

    def _mixed(
        self, depth: Depth, signal: Depth, capture: Capture, film: FilmImage | None = None
    ) -> tuple[Depth, Bool[np.ndarray, "h w"], Depth]:
        """Return the depth (m) of all light that ends in a pixel, where its phases do not cancel, and that light.

        A pixel adds up amplitude and phase; at an edge the sum lies between the two sides, a flying pixel.
        """
        lit = (depth > 0) & (signal > 0)
        spot = self.sigma_lateral_px * capture.camera.fx / self.focal_px
        if spot == 0 and self.stray_light == 0 and not self.needs_reflections and film is None:
            return depth.copy(), lit, signal
        turn, away = 2.0 * np.pi / self.unambiguous_range, cosine_of_view(capture.camera)
        ranges, whole = depth / away, signal
        real, imaginary = added(signal, ranges, turn)
        if self.needs_reflections:
            assert capture.surfaces is not None
            assert capture.surfaces.reflected is not None
            mirrored = capture.surfaces.reflected
            light = np.float32(self.reflections) * mirrored.light
            more = added(light, mirrored.ranges, turn)
            real, imaginary, whole = real + more[0], imaginary + more[1], whole + light
        if film is not None:
            light = np.minimum(film.light / np.square(film.depth), np.float32(_SATURATED))
            more = added(light, np.where(light > 0, film.depth, depth) / away, turn)
            real, imaginary, whole = real + more[0], imaginary + more[1], whole + light
        arrived, stray = whole, scattered(real, imaginary, self.stray_light)
        if spot > 0:
            real, imaginary = gathered(real, spot), gathered(imaginary, spot)
        clear = lit
        if self.min_coherence > 0:
            clear = lit & (cv2.magnitude(real, imaginary) >= np.float32(self.min_coherence) * gathered(whole, spot))
        off = read_off(real + stray[0], imaginary + stray[1], ranges, turn)
        return np.maximum(depth + off * away, np.float32(0.0)), clear, arrived


@lru_cache(maxsize=4)
def cosine_of_view(camera: PinholeCamera) -> Float32[np.ndarray, "h w"]:
    """Return z over range for each pixel."""
    x, y = pixel_tangents(camera)
    cosine = np.float32(1.0) / np.sqrt(np.float32(1.0) + x * x + y * y)
    cosine.setflags(write=False)
    return cosine
