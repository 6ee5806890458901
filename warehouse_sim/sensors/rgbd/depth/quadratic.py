"""Depth in a few numbers: exact within a range, or with noise that grows with distance and steps in disparity."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.depth.model import Depth, DepthModel
from warehouse_sim.sensors.rgbd.depth.noise import unit_noise


@dataclass(frozen=True)
class IdealDepth(DepthModel):
    """A camera without errors."""

    kind: ClassVar[str] = "ideal"
    needs_color: ClassVar[bool] = False

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the clean depth (m)."""
        return buffers.depth


@dataclass(frozen=True)
@ranged
class QuadraticDepth(DepthModel):
    """Gaussian noise of ``sigma(z) = sigma_base + sigma_quadratic * z^2``, whatever the surface; no holes.

    Triangulation gives ``z = f b / d``, so an error of the disparity ``d`` grows as ``dz = z^2 / (f b) dd``.
    """

    kind: ClassVar[str] = "quadratic"
    needs_color: ClassVar[bool] = False

    sigma_base: Annotated[float, Range(0, 10, "m")] = 0.001
    """Standard deviation of depth that does not grow with distance (m), 0-10."""
    sigma_quadratic: Annotated[float, Range(0, 10, "1/m")] = 0.001
    """Growth of that standard deviation with the square of depth (1/m), 0-10: stereo's z^2 law."""
    correlation_px: ClassVar[int] = 5
    """Edge of the window over which depth noise is alike (px), odd; 1 = each pixel by itself."""
    inverse_depth_step: Annotated[float, Range(0, 10, "1/m")] = 0.0
    """Step in which 1 / depth is read, as disparity is (1/m), 0-10; 0 = continuous."""

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return depth with the noise of the formula (m)."""
        depth = result = buffers.depth
        base, quadratic = self.noise_scale * self.sigma_base, self.noise_scale * self.sigma_quadratic
        if base > 0 or quadratic > 0:
            sigma = np.float32(base) + np.float32(quadratic) * depth * depth
            result = depth + sigma * unit_noise((depth.shape[0], depth.shape[1]), rng, self.correlation_px)
        if self.inverse_depth_step > 0:
            step = np.float32(self.inverse_depth_step)
            inverse = np.divide(np.float32(1.0), result, out=np.zeros_like(result), where=result > 0)
            steps = np.rint(inverse / step) * step
            result = np.divide(np.float32(1.0), steps, out=np.zeros_like(result), where=steps > 0)
        return np.where(depth > 0, np.maximum(result, np.float32(0.0)), np.float32(0.0))
