"""Settings of an RGB-D camera."""

from dataclasses import dataclass, field

from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.rgbd.depth import DepthModel, QuadraticDepth, read_depth_model


@dataclass(frozen=True)
class RgbdConfig:
    """A depth camera and a colour camera that share their pixels."""

    depth: DepthModel = field(default_factory=QuadraticDepth, metadata={"from_plain": read_depth_model})
    """A preset's name (kinect_v1, d435, d455, flexx2, azure_kinect, tof_industrial), or model and settings."""
    color: ColorConfig = field(default_factory=ColorConfig)
    """Exposure, noise and lens; ``ideal`` = none."""
