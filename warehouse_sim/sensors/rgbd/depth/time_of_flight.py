"""A camera that measures the phase of modulated light in each pixel."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32

from warehouse_sim.ranges import Range, Share, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.pixel_rays import pixel_tangents
from warehouse_sim.sensors.rgbd.depth.model import Depth, DepthModel
from warehouse_sim.sensors.rgbd.depth.multipath import multipath_bias
from warehouse_sim.sensors.rgbd.depth.noise import odd_window, unit_noise
from warehouse_sim.sensors.surfaces import facing_cosine, returned_light

_SATURATED = 1e3
"""Light beyond which more of it does not help (white plaster facing the emitter from 1 m gives 1)."""


@dataclass(frozen=True)
@ranged
class TimeOfFlight(DepthModel):
    """Noise by range, angle and reflectance; flying pixels at edges; longer ranges in corners.

    The noise is that of Cai et al. 2024, "Noise analysis and modeling of the PMD Flexx2 depth camera for robotic
    applications" (arXiv 2412.15040), measured on white; the defaults are its mode 5 at 30 frames a second. On darker
    surfaces it grows as 1 / sqrt(reflectance), as shot noise of the emitter's own light does (Lange & Seitz 2001,
    "Solid-state time-of-flight range camera").
    """

    kind: ClassVar[str] = "time_of_flight"
    needs_normals: ClassVar[bool] = True
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
    unambiguous_range: Annotated[float, Range(0.1, 500, "m")] = 7.5
    """Range at which the phase, put together from all frequencies, starts anew (m), 0.1-500."""
    min_coherence: Share = 0.6
    """Least length of the sum of phases in a pixel's spot, relative to the sum of their lengths, 0-1."""
    min_signal: Annotated[float, Range(0, 1000)] = 0.0005
    """Least light of the emitter that must come back, 0-1,000; white plaster facing it from 1 m gives 1."""
    max_sigma: Annotated[float, Range(0.00001, 100, "m")] = 0.1
    """Readings of a larger standard deviation are dropped, as confidence filters do (m), 0.00001-100."""
    multipath: Share = 1.0
    """Share of the light by way of other surfaces that is not compensated, 0-1."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sigma_linear < 0 and self.sigma_linear**2 >= 4.0 * self.sigma_base * self.sigma_square:
            raise ValueError(f"sigma_linear makes the noise negative at some range, found {self.sigma_linear}")

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none."""
        assert buffers.normals is not None
        assert capture.surfaces is not None
        camera, depth = capture.camera, buffers.depth
        cosine = facing_cosine(buffers.normals, camera)
        diffuse, glossy = returned_light(capture.surfaces, cosine)
        signal = np.divide(diffuse + glossy, depth * depth, out=np.zeros_like(depth), where=depth > 0)
        mixed, clear = self._mixed(depth, np.minimum(signal, np.float32(_SATURATED)), camera.fx / self.focal_px)
        if self.multipath > 0:
            share = np.float32(self.multipath)
            bias = multipath_bias(depth, buffers.normals, capture.surfaces.remission, camera)
            mixed += share * bias * cosine_of_view(capture)
        theta = np.arccos(np.clip(cosine, np.float32(0.05), np.float32(1.0)))
        white = np.clip(capture.surfaces.remission, np.float32(0.01), np.float32(1.0))
        sigma = np.float32(self.noise_scale) * self.axial_sigma(depth, theta) / np.sqrt(white)
        # Pixels of the image that lie on one pixel of the sensor have its error in common.
        size = (depth.shape[0], depth.shape[1])
        read = mixed + sigma * unit_noise(size, rng, odd_window(camera.fx / self.focal_px))
        clear &= (signal >= np.float32(self.min_signal)) & (sigma <= np.float32(self.max_sigma))
        return np.where(clear, read, np.float32(0.0))

    def axial_sigma(self, z: Float[np.ndarray, "*s"], theta: Float[np.ndarray, "*s"]) -> Float[np.ndarray, "*s"]:
        """Return the standard deviation of depth (m) on white, from z (m) and the angle of incidence (rad)."""
        lean = theta / (np.float32(np.pi / 2) - theta)
        straight = np.float32(self.sigma_base) + z * (np.float32(self.sigma_linear) + np.float32(self.sigma_square) * z)
        return straight + np.float32(self.sigma_angle) * z ** np.float32(2.7) * lean * lean

    def _mixed(
        self, depth: Depth, signal: Float32[np.ndarray, "h w"], scale: float
    ) -> tuple[Depth, Bool[np.ndarray, "h w"]]:
        """Return the depth (m) of all light in a pixel's spot, and where its phases do not cancel each other.

        A pixel adds up amplitude and phase; at an edge the sum lies between the two sides, a flying pixel.
        """
        lit = (depth > 0) & (signal > 0)
        if self.sigma_lateral_px == 0:
            return depth.copy(), lit
        turn = np.float32(2.0 * np.pi / self.unambiguous_range)
        phase = turn * depth
        size = 2 * int(np.ceil(2.0 * self.sigma_lateral_px * scale)) + 1
        spot = (size, size), self.sigma_lateral_px * scale
        real = cv2.GaussianBlur(signal * np.cos(phase), *spot)
        imaginary = cv2.GaussianBlur(signal * np.sin(phase), *spot)
        whole = cv2.GaussianBlur(signal, *spot)
        found = cv2.phase(real, imaginary)
        off = np.remainder(found - phase + np.float32(np.pi), np.float32(2 * np.pi)) - np.float32(np.pi)
        clear = cv2.magnitude(real, imaginary) >= np.float32(self.min_coherence) * whole
        return np.maximum(depth + off / turn, np.float32(0.0)), lit & clear


def cosine_of_view(capture: Capture) -> Float32[np.ndarray, "h w"]:
    """Return z over range for each pixel."""
    x, y = pixel_tangents(capture.camera)
    return np.float32(1.0) / np.sqrt(np.float32(1.0) + x * x + y * y)
