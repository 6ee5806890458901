"""Depth as any triangulating sensor measures it, in two numbers: noise that grows with distance, steps in disparity."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.depth.model import Depth, DepthModel, require_not_negative
from warehouse_sim.sensors.depth.noise import unit_noise
from warehouse_sim.sensors.shot import Shot


@dataclass(frozen=True)
class QuadraticDepth(DepthModel):
    """Gaussian noise of ``sigma(z) = sigma_base + sigma_quadratic * z^2``, whatever the surface; no holes.

    Triangulation gives ``z = f b / d``, so an error of the disparity ``d`` grows as ``dz = z^2 / (f b) dd``.
    """

    kind: ClassVar[str] = "quadratic"

    sigma_base: float = 0.001
    """Standard deviation of depth that does not grow with distance (m), >= 0."""
    sigma_quadratic: float = 0.001
    """Growth of that standard deviation with the square of depth (1/m), >= 0: stereo's z^2 law."""
    correlation_px: int = 5
    """Edge of the window over which depth noise is alike (px), odd; 1 = each pixel by itself."""
    inverse_depth_step: float = 0.0
    """Step in which 1 / depth is read, as disparity is (1/m), >= 0; 0 = continuous."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_not_negative(self, "sigma_base", "sigma_quadratic", "inverse_depth_step")
        if self.correlation_px < 1 or self.correlation_px % 2 == 0:
            raise ValueError(f"correlation_px must be odd and at least 1, found {self.correlation_px}")

    def measure(self, buffers: RenderBuffers, shot: Shot, rng: np.random.Generator) -> Depth:
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
