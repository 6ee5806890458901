"""Colour cameras: a clean image becomes what a sensor behind a lens makes of it."""

from warehouse_sim.sensors.rgbd.color.camera import read_color
from warehouse_sim.sensors.rgbd.color.config import COLOR_PRESETS, IDEAL_COLOR, ColorConfig

__all__ = ["COLOR_PRESETS", "IDEAL_COLOR", "ColorConfig", "read_color"]
