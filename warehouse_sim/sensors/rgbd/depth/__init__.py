"""Depth cameras: clean depth becomes what a sensor of one kind or another reads of it."""

from warehouse_sim.sensors.rgbd.depth.model import DepthModel
from warehouse_sim.sensors.rgbd.depth.models import MODELS, PRESETS, read_depth_model
from warehouse_sim.sensors.rgbd.depth.quadratic import QuadraticDepth

__all__ = ["MODELS", "PRESETS", "DepthModel", "QuadraticDepth", "read_depth_model"]
