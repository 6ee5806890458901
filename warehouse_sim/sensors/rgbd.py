"""An RGB-D camera: what it reads where the clean image and depth are known."""

from dataclasses import dataclass, field

import numpy as np

from warehouse_sim.schema import RenderBuffers, RgbdReading
from warehouse_sim.sensors.color import ColorConfig, read_color
from warehouse_sim.sensors.depth import DepthModel, QuadraticDepth
from warehouse_sim.sensors.shot import Shot


@dataclass(frozen=True)
class RgbdConfig:
    """A depth camera and a colour camera that share their pixels."""

    depth: DepthModel = field(default_factory=QuadraticDepth)
    """A preset's name (kinect_v1, d435, d455, flexx2, azure_kinect), or model and settings."""
    color: ColorConfig = field(default_factory=ColorConfig)
    """Exposure, noise and lens; ``ideal`` = none."""


def read_rgbd(buffers: RenderBuffers, shot: Shot, config: RgbdConfig, rng: np.random.Generator) -> RgbdReading:
    """Return what the camera reads of a clean rendering.

    Depth and colour have random streams of their own, both made from ``rng``: settings of one never change the other.

    Args:
        buffers: The clean truth.
        shot: How the picture is taken.
        config: The camera.
        rng: Source of all errors.
    """
    depth_rng, color_rng = rng.spawn(2)
    return RgbdReading(
        rgb=read_color(buffers, shot, config.color, color_rng),
        depth=config.depth.read(buffers, shot, depth_rng),
    )
