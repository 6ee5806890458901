"""A camera that triangulates with a projected dot pattern, as the first Kinect did."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32

from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.film import FilmImage
from warehouse_sim.sensors.rgbd.depth.edges import baseline_shadow, inverse_depth, jitter_jumps
from warehouse_sim.sensors.rgbd.depth.model import Depth, LitDepth
from warehouse_sim.sensors.rgbd.depth.noise import border_noise, odd_window, unit_noise
from warehouse_sim.sensors.rgbd.depth.pattern import FilmedDots
from warehouse_sim.sensors.surfaces import facing_cosine, returned_by_retroreflectors, returned_light
from warehouse_sim.sensors.view import Capture

_WINDOW_PX = 9.0
"""Edge of the window in which the dots are matched (px of the camera)."""
_AGREEING = 1.0 / 1.2
"""Least fraction of the window's dots that must lie on one plane."""
_PAIRS = ((4, 0), (0, 4), (4, 4), (4, -4), (2, 1), (-1, 2), (4, 2), (-2, 4))
"""Places of the window that stand for its dots, with those opposite (px of the camera)."""
_RAGGED = 0.3
"""Standard deviation of the natural logarithm of a hole's threshold: borders of holes are not straight."""
_RIVAL_PX = 0.2
"""Standard deviation of disparity (px) where dots on film are as bright as those behind it; no source: a prior."""


@dataclass(frozen=True)
@ranged
class StructuredLight(LitDepth):
    """Noise by range and angle; depth in steps of disparity; holes in shadows, at edges and at grazing incidence.

    Noise: Nguyen, Izadi & Lovell 2012, "Modeling Kinect sensor noise for improved 3D reconstruction and tracking",
    fitted up to about 3 m. Steps of disparity, shifted places and the vote of the window: Barron & Malik 2013 and Handa
    et al. 2014, "A benchmark for RGB-D visual odometry, 3D reconstruction and SLAM". That dark, shiny and steep
    surfaces are lost: Khoshelham & Elberink 2012, "Accuracy and resolution of Kinect depth data for indoor mapping
    applications", which gives no threshold.
    """

    kind: ClassVar[str] = "structured_light"
    needs_normals: ClassVar[bool] = True
    needs_color: ClassVar[bool] = False
    needs_surfaces: ClassVar[bool] = True

    min_range: Annotated[float, Range(0, 500, "m")] = 0.8
    """Nearest depth that is read (m), 0-500; the Kinect's default range is 0.8-4 m."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 4.0
    """Farthest depth that is read (m), > min_range, 0.01-500."""
    focal_px: ClassVar[float] = 585.5
    """Focal length of the sensor itself (px); with the baseline, 8 f b = 351.3 m as in Handa's model."""
    baseline: ClassVar[float] = 0.075
    """From the camera to the projector (m)."""
    disparity_step: ClassVar[float] = 0.125
    """Step of disparity (px of the sensor)."""
    agreement_px: ClassVar[float] = 0.3
    """How far dots of a window may lie off the plane through it, in disparity (px of the sensor)

    Handa's 0.1 would lose every edge of a box, where the surface bends but does not jump.
    """
    max_angle_deg: ClassVar[float] = 80.0
    """Largest angle of incidence that is read (deg); the noise was fitted below 80."""
    min_signal: ClassVar[float] = 0.012
    """Least light of the dots that must come back; white plaster facing the projector from 1 m gives 1. No
    source: white is read to the end of the range at 70 degrees, cardboard straight on, black plastic to 2.2 m."""
    max_glare: ClassVar[float] = 2.0
    """Most glossy light that may come back, relative to white plaster at the same place: dots that
    saturate run into each other. No source."""

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none."""
        assert buffers.normals is not None
        gt, scale = buffers.depth, capture.camera.fx / self.focal_px
        cosine = np.minimum(facing_cosine(buffers.normals, capture.camera), np.float32(1.0))
        angle = np.arccos(cosine)
        theta = np.minimum(angle, np.float32(np.deg2rad(self.max_angle_deg)))
        lost = baseline_shadow(np.float32(capture.camera.fx * self.baseline) * inverse_depth(gt), capture.camera)
        lost |= angle > np.float32(np.deg2rad(self.max_angle_deg))
        size = (gt.shape[0], gt.shape[1])
        depth = jitter_jumps(gt, np.float32(scale * self.noise_scale) * lateral_sigma(theta), rng)
        noise = unit_noise(size, rng, odd_window(_WINDOW_PX * scale))
        # Drawn last: what the fits say of noise does not depend on it.
        ragged = np.exp(np.float32(_RAGGED) * border_noise(size, rng, _WINDOW_PX * scale))
        unit = np.float32(self.focal_px * self.baseline)
        lost |= ~self._agreed(unit * inverse_depth(gt), scale)
        unlit, film = self._dots(gt, cosine, capture, ragged)
        lost |= unlit
        if film is not None:
            depth = np.where(film[0].on_film & (depth > 0), film[1].depth, depth)
        # The published noise holds that of the steps, whose variance is step^2 / 12.
        step = np.float32(self.disparity_step) * np.square(depth) / unit
        sigma = np.float32(self.noise_scale) * axial_sigma(np.maximum(depth, np.float32(0.1)), theta)
        rest = np.sqrt(np.maximum(np.square(sigma) - np.square(step) / np.float32(12.0), np.float32(0.0)))
        if film is not None:
            more = film[0].variance(_RIVAL_PX) * np.square(np.float32(self.noise_scale) * np.square(depth) / unit)
            rest = np.sqrt(np.square(rest) + more)
        noisy = depth + rest * noise
        steps = np.rint(unit * inverse_depth(np.maximum(noisy, 0)) / np.float32(self.disparity_step))
        read = np.divide(unit / np.float32(self.disparity_step), steps, out=np.zeros_like(noisy), where=steps > 0)
        return np.where(lost | (depth <= 0), np.float32(0.0), read)

    def _dots(
        self, depth: Depth, cosine: Depth, capture: Capture, factor: Depth
    ) -> tuple[Bool[np.ndarray, "h w"], tuple[FilmedDots, FilmImage] | None]:
        """Return where too few dots come back, or too bright ones, and what film makes of them; None = no film."""
        assert capture.surfaces is not None
        diffuse, glossy = returned_light(capture.surfaces, cosine)
        mirrored = returned_by_retroreflectors(capture.surfaces.remission, cosine, depth, self.baseline)
        if mirrored is not None:
            glossy = glossy + mirrored
        least = np.float32(self.min_signal) * factor
        if capture.film is None or not self.film:
            weak = diffuse + glossy < least * np.square(depth)
            return weak | (glossy > np.float32(self.max_glare) * factor), None
        film = capture.film.whole(depth)
        dots = np.divide(diffuse + glossy, np.square(depth), out=np.zeros_like(depth), where=depth > 0)
        seen = FilmedDots.of(dots, depth, film, factor, 1.0, self.focal_px * self.baseline)
        glossy = glossy * np.square(film.passed) + film.glossy
        return (seen.dots < least) | (glossy > np.float32(self.max_glare) * factor), (seen, film)

    def _agreed(self, disparity: Float32[np.ndarray, "h w"], scale: float) -> Bool[np.ndarray, "h w"]:
        """Return where enough of the window lies on one plane.

        Disparity is linear over the image of a plane, so that the mean of two opposite places is that of the centre.
        """
        height, width = disparity.shape
        pairs = [(round(scale * x), round(scale * y)) for x, y in _PAIRS]
        margin = max(max(abs(x), abs(y)) for x, y in pairs)
        padded = cv2.copyMakeBorder(disparity, margin, margin, margin, margin, cv2.BORDER_REPLICATE)
        twice, votes = np.float32(2.0) * disparity, np.zeros(disparity.shape, np.uint8)
        for x, y in pairs:
            one, other = (
                padded[margin + way * y : margin + way * y + height, margin + way * x : margin + way * x + width]
                for way in (1, -1)
            )
            votes += np.abs(one + other - twice) < np.float32(2.0 * self.agreement_px)
        return votes >= _AGREEING * len(pairs)


def axial_sigma(z: Float[np.ndarray, "*s"], theta: Float[np.ndarray, "*s"]) -> Float[np.ndarray, "*s"]:
    """Return the standard deviation of depth (m) by Nguyen et al. 2012, from z (m) and the angle of incidence (rad)."""
    lean = theta / (np.float32(np.pi / 2) - theta)
    return (
        np.float32(0.0012) + np.float32(0.0019) * (z - np.float32(0.4)) ** 2 + np.float32(0.0001) / np.sqrt(z) * lean**2
    )


def lateral_sigma(theta: Float[np.ndarray, "*s"]) -> Float[np.ndarray, "*s"]:
    """Return the standard deviation of where an edge is seen (px of the Kinect) by Nguyen et al. 2012."""
    return np.float32(0.8) + np.float32(0.035) * theta / (np.float32(np.pi / 2) - theta)
