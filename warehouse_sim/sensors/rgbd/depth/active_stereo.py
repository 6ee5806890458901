"""A stereo camera with an infrared projector, such as Intel's RealSense D400 series."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.film import FilmImage
from warehouse_sim.sensors.pixel_rays import pixel_tangents
from warehouse_sim.sensors.rgbd.depth.edges import baseline_shadow, fattened, inverse_depth, widened
from warehouse_sim.sensors.rgbd.depth.model import Depth, LitDepth
from warehouse_sim.sensors.rgbd.depth.noise import border_noise, odd_window, smooth_noise
from warehouse_sim.sensors.rgbd.depth.pattern import (
    FilmedDots,
    StereoUnit,
    clarity,
    doubled,
    hall_light,
    halved,
    shifted,
    texture_slope,
)
from warehouse_sim.sensors.surfaces import Surfaces, returned_by_retroreflectors, returned_light
from warehouse_sim.sensors.view import Capture

_RAGGED = 0.32
"""Standard deviation of the natural logarithm of a hole's threshold: borders of holes are not straight."""
_TEXTURED_PX = 0.032
"""Standard deviation of disparity on a passive texture without noise (px): what a well calibrated D400 reaches on a
well textured scene, by its maker; laser dots add the noise of their speckle (librealsense, issue 3904)."""
_DENSE = 0.3
"""Variance that the noise of images leaves on texture, relative to that on dots of the same mean slope."""
_STEP_PX = 1.0
"""Least step of disparity at which things grow (px of the sensor); what is less is a slope."""


@dataclass(frozen=True)
@ranged
class ActiveStereo(LitDepth):
    """Errors of disparity that matching windows share, and holes where neither dots nor texture can be matched.

    ``z = f b / d`` and ``dz = z^2 dd / (f b)``, with 1/32 px steps (Grunnet-Jepsen et al., "Subpixel linearity
    improvement for Intel RealSense depth camera D400 series"). The error of disparity is ``subpixel_px`` where the
    pattern is bright, and grows with the noise of the images over the slopes in them, so with distance, light of the
    hall and angle, and with the slope of the surface. The defaults are those of a D435 at 848 x 480: 15 mm at 2 m, as
    Rustler et al. 2025 (arXiv 2501.07421) measured, 0.75 %, and within a quarter of Ahn et al. 2019 up to 4 m. What
    has no published figure was fitted to images that were rendered and matched
    (``tests/sensors/rgbd/depth/dots``).
    """

    kind: ClassVar[str] = "active_stereo"
    needs_normals: ClassVar[bool] = True
    needs_surfaces: ClassVar[bool] = True

    min_range: Annotated[float, Range(0, 500, "m")] = 0.1
    """Nearest depth that is read (m), 0-500; see also ``search_px``."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 10.0
    """Farthest depth that is read (m), > min_range, 0.01-500."""
    focal_px: Annotated[float, Range(50, 20_000, "px")] = 424.0
    """Focal length of the infrared cameras (px), 50-20,000: 90 degrees over 848 px."""
    baseline: Annotated[float, Range(0.001, 2, "m")] = 0.050
    """Between the infrared cameras (m), 0.001-2."""
    color_offset: Annotated[float, Range(-2, 2, "m")] = -0.015
    """Place of the colour camera to the right of the left infrared camera (m), -2 to 2: what one of the two infrared
    cameras does not see of the colour image is a hole; 0 = in its place. As devices report it (``rs-enumerate-devices
    -c``): -0.015 (D435), 0.059 (D455)."""
    subpixel_px: Annotated[float, Range(0, 100, "px")] = 0.077
    """Standard deviation of disparity where dots are bright (px of the infrared cameras), 0-100."""
    blurred_px: ClassVar[float] = 0.22
    """That where slopes in the images are as large as their noise (px of the infrared cameras)."""
    slope_px: ClassVar[float] = 0.7
    """That per px of disparity by which a surface slopes from one pixel to the next (px)."""
    window_px: ClassVar[float] = 7.0
    """Edge of the matching window, over which errors are alike (px of the infrared cameras)."""
    edge_px: ClassVar[float] = 2.5
    """By how much near things grow over far ones (px of the infrared cameras); less than half a window."""
    shadow_px: ClassVar[float] = 2.05
    """By how much the shadow of the baseline is wider than its geometry, as windows reach into it (px of the infrared
    cameras)."""
    disparity_step: ClassVar[float] = 0.03125
    """Step of disparity (px of the infrared cameras)."""
    search_px: ClassVar[float] = 126.0
    """Largest disparity that is looked for (px of the infrared cameras): none nearer than f b / search_px."""
    projector_lux: ClassVar[float] = 1000.0
    """Light of a dot's middle 1 m away, as the illuminance by white light that the cameras see alike (lx). No source:
    with it, a D435 reads a white wall in 300 lx up to about 6 m."""
    min_clarity: ClassVar[float] = 0.56
    """Least slope in the images that can be matched, relative to their noise."""
    min_cosine: ClassVar[float] = 0.05
    """Cosine of incidence below which the pattern is too squeezed to be matched."""
    max_slope: ClassVar[float] = 0.65
    """Most disparity by which a matched surface slopes from one pixel to the next (px per px)."""
    max_glare: ClassVar[float] = 4.0
    """Most glossy light that may come back, relative to white plaster at the same place. No source."""
    unit_scale: ClassVar[float] = 0.003
    """Standard deviation over units of the error of all depths, as a fraction. No source: with the bow, 2 % at 2 m
    (D435) are kept."""
    unit_bow_px: ClassVar[float] = 0.05
    """That of the disparity by which planes seem bowed or tilted towards the image's border (px). No source."""
    unit_registration_px: ClassVar[float] = 0.5
    """That of where depth is registered beside colour (px of the infrared cameras). No source."""

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none."""
        unit, scale = np.float32(self.focal_px * self.baseline), capture.camera.fx / self.focal_px
        own = StereoUnit.sample(self.built, *(self.noise_scale * value for value in (
            self.unit_scale, self.unit_bow_px, self.unit_registration_px * scale)))  # fmt: skip
        inverse = inverse_depth(buffers.depth)
        size = (inverse.shape[0], inverse.shape[1])
        window = self.window_px * scale
        error, ragged = smooth_noise(size, rng, window), border_noise(size, rng, window)
        sigma, unclear, filmed = self._error(buffers, capture, ragged)
        # Everything below is of the true surface; noise comes on top of what the window has chosen.
        matched, grew = fattened(unit * inverse, self.edge_px * scale, ragged, _STEP_PX)
        lost = (self._hidden(inverse, capture, ragged) & ~grew) | unclear
        if filmed is not None:
            assert capture.film is not None
            self._match_film(matched, unit * inverse, capture.film, *filmed)
        lost |= (matched > np.float32(self.search_px)) | (matched <= 0)
        matched += cv2.multiply(sigma, error)
        matched += own.offset(capture.camera)
        matched *= np.float32(1.0 / self.disparity_step)
        steps = np.rint(matched, out=matched)
        top = unit / np.float32(self.disparity_step) * np.float32(1.0 + own.scale)
        # What is lost is nothing; one step is too far to be read.
        lost |= steps < 1
        np.copyto(steps, np.inf, where=lost)
        return shifted(top / steps, own.shift_uv)

    def _hidden(self, inverse: Depth, capture: Capture, ragged: Depth) -> Bool[np.ndarray, "h w"]:
        """Return what either infrared camera does not see of the colour image; of every second row, taken twice."""
        places = (-self.color_offset, self.baseline - self.color_offset)
        camera, plain = capture.camera, capture.camera.distortion is None
        rows, swing = (image[::2] if plain else image for image in (inverse, ragged))
        hidden = np.zeros(rows.shape, bool)
        reach = self.shadow_px * camera.fx / self.focal_px
        for place in places:
            if place != 0:
                shadow = baseline_shadow(np.float32(camera.fx * place) * rows, camera)
                hidden |= widened(shadow, reach, place > 0, swing)
        return np.repeat(hidden, 2, axis=0)[: inverse.shape[0]] if plain else hidden

    def _error(
        self, buffers: RenderBuffers, capture: Capture, ragged: Depth
    ) -> tuple[Depth, Bool[np.ndarray, "h w"], tuple[tuple[slice, slice], FilmedDots] | None]:
        """Return the standard deviation of disparity (px of the sensor), where nothing can be matched, and film."""
        assert buffers.normals is not None
        assert capture.surfaces is not None
        normals, depth = halved(buffers.normals), np.maximum(halved(buffers.depth), np.float32(0.01))
        cosine, along = _facing(normals, capture)
        seen = capture.surfaces
        surfaces = Surfaces(halved(seen.remission), halved(seen.roughness), halved(seen.metallic))
        diffuse, glossy = returned_light(surfaces, cosine)
        # The projector lies between the infrared cameras, about half a baseline from either. No source.
        mirrored = returned_by_retroreflectors(surfaces.remission, cosine, depth, self.baseline / 2)
        if mirrored is not None:
            glossy = glossy + mirrored
        dots = np.float32(self.projector_lux) * (diffuse + glossy) / np.square(depth)
        film = self._filmed(dots, glossy, depth, capture, ragged)
        scale = capture.camera.fx / self.focal_px
        hall = hall_light(buffers.rgb, capture.exposure_ev)
        texture = np.float32(scale) * texture_slope(hall, odd_window(self.window_px * scale))
        clear, by_dots = clarity(np.ascontiguousarray(hall[:, ::2]), dots, texture)
        # 1 / z of a plane changes by n / (f n.p) from pixel to pixel.
        slope = np.float32(self.baseline) * np.sqrt(np.maximum(1 - np.square(normals[..., 2]), 0)) / (depth * along)
        texture_fraction = np.float32(1.0) - by_dots
        variance = np.float32(self.subpixel_px**2) * np.square(by_dots) + np.float32(_TEXTURED_PX**2) * texture_fraction
        variance += np.square(np.float32(self.slope_px) * slope)
        # Texture is everywhere in the window, dots are points of it.
        spread = np.float32(self.blurred_px**2) * (by_dots + np.float32(_DENSE) * texture_fraction)
        variance += spread / np.square(np.maximum(clear, np.float32(0.05)))
        if film is not None:
            variance[film[0]] += film[1].variance(self.blurred_px)
        factor = np.exp(np.float32(_RAGGED) * halved(ragged))
        unclear = (clear < np.float32(self.min_clarity) * factor) | (cosine < np.float32(self.min_cosine) * factor)
        unclear |= (slope * factor > np.float32(self.max_slope)) | (glossy > np.float32(self.max_glare) * factor)
        size = (buffers.depth.shape[0], buffers.depth.shape[1])
        whole = doubled(unclear.view(np.uint8), size, cv2.INTER_NEAREST).view(bool)
        return doubled(np.float32(self.noise_scale) * np.sqrt(variance), size), whole, film

    def _filmed(
        self, dots: Depth, glossy: Depth, depth: Depth, capture: Capture, ragged: Depth
    ) -> tuple[tuple[slice, slice], FilmedDots] | None:
        """Return where there is film and what is seen of the dots there, all halved; None = there is none.

        Args:
            dots: Light of the dots behind; changed to that of the dots that are matched.
            glossy: Light that surfaces mirror; changed to that with the film's.
            depth: Of what is solid (m).
            capture: With the film.
            ragged: Noise of the borders of patches, not halved.
        """
        if capture.film is None or not self.film:
            return None
        window = capture.film.window
        film = capture.film.within(window)
        factor = np.exp(np.float32(_RAGGED) * halved(ragged)[window])
        unit = self.focal_px * self.baseline
        seen = FilmedDots.of(dots[window], depth[window], film, factor, self.projector_lux, unit)
        dots[window] = seen.dots
        glossy[window] = glossy[window] * np.square(film.passed) + film.glossy
        return window, seen

    def _match_film(
        self, matched: Depth, true: Depth, film: FilmImage, window: tuple[slice, slice], seen: FilmedDots
    ) -> None:
        """Put the disparity (px of the sensor) of film into ``matched`` where its dots are, if it is before the rest.

        Args:
            matched: Of the image; changed.
            true: Of what is solid.
            film: Halved.
            window: Its rows and columns that hold film.
            seen: Which dots are matched there.
        """
        size = matched.shape
        place = tuple(slice(2 * side.start, min(2 * side.stop, n)) for side, n in zip(window, size, strict=True))
        own = np.where(seen.on_film, np.float32(self.focal_px * self.baseline) / film.depth[window], np.float32(0.0))
        grown = own.repeat(2, axis=0).repeat(2, axis=1)[: matched[place].shape[0], : matched[place].shape[1]]
        np.copyto(matched[place], grown, where=grown > true[place])


def _facing(normals: Float32[np.ndarray, "h w 3"], capture: Capture) -> tuple[Depth, Depth]:
    """Return the cosine of incidence, and the normal's component along the ray to z = 1, of a halved image."""
    x, y = pixel_tangents(capture.camera)
    x, y = x[:: 1 if x.shape[0] == 1 else 2, ::2], y[::2, :: 1 if y.shape[1] == 1 else 2]
    along = np.abs(normals[..., 0] * x + normals[..., 1] * y + normals[..., 2])
    return along / np.sqrt(np.float32(1.0) + x * x + y * y), np.maximum(along, np.float32(1e-3))
