"""RGB-D cameras: a clean rendering becomes the colours and the depth that a real camera would give."""

from warehouse_sim.sensors.rgbd.read import RgbdConfig, read_rgbd

__all__ = ["RgbdConfig", "read_rgbd"]
