"""An RGB-D camera: what it reads where the clean image and depth are known."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.schema import RenderBuffers, RgbdReading
from warehouse_sim.sensors.color_noise import add_color_noise
from warehouse_sim.sensors.depth_noise import disturb_depth


@dataclass(frozen=True)
class RgbdConfig:
    """Noise of an RGB-D camera; all noise settings 0 = the clean truth within the range limits."""

    sigma_base: float = 0.001
    """Standard deviation of depth that does not grow with distance (m), >= 0."""
    sigma_quadratic: float = 0.001
    """Growth of that standard deviation with the square of depth (1/m), >= 0: stereo's z^2 law."""
    correlation_px: int = 5
    """Edge of the window over which depth noise is alike (px), odd; 1 = each pixel by itself."""
    inverse_depth_step: float = 0.0
    """Step in which 1 / depth is read, as disparity is (1/m), >= 0; 0 = continuous."""
    min_range: float = 0.3
    """Nearest depth that is read (m), >= 0."""
    max_range: float = 30.0
    """Farthest depth that is read (m), > min_range."""
    shot_noise: float = 0.0002
    """Variance of linear colour (1 = white) per linear value, >= 0; Brooks et al. 2019 use 0.0001-0.012."""
    read_noise: float = 0.000001
    """Variance of linear colour that does not depend on the value, >= 0."""

    def __post_init__(self) -> None:
        amounts = ("sigma_base", "sigma_quadratic", "inverse_depth_step", "min_range", "shot_noise", "read_noise")
        for name in amounts:
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must not be negative, found {getattr(self, name)}")
        if self.correlation_px < 1 or self.correlation_px % 2 == 0:
            raise ValueError(f"correlation_px must be odd and at least 1, found {self.correlation_px}")
        if self.max_range <= self.min_range:
            raise ValueError(f"max_range must exceed min_range {self.min_range}, found {self.max_range}")


def read_rgbd(buffers: RenderBuffers, config: RgbdConfig, rng: np.random.Generator) -> RgbdReading:
    """Return what the camera reads of a clean rendering."""
    depth = disturb_depth(
        buffers.depth,
        rng,
        sigma_base=config.sigma_base,
        sigma_quadratic=config.sigma_quadratic,
        correlation_px=config.correlation_px,
        inverse_depth_step=config.inverse_depth_step,
    )
    usable = (buffers.depth >= config.min_range) & (buffers.depth <= config.max_range) & (depth > 0)
    rgb = add_color_noise(buffers.rgb, rng, shot=config.shot_noise, read=config.read_noise)
    return RgbdReading(rgb=rgb, depth=np.where(usable, depth, np.float32(0.0)))
