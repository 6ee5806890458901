"""Depth cameras: clean depth becomes what a sensor of one kind or another reads of it."""

from warehouse_sim.sensors.rgbd.depth.model import DepthModel, QuadraticDepth
from warehouse_sim.sensors.rgbd.depth.models import MODELS, PRESETS, read_depth_model

__all__ = ["MODELS", "PRESETS", "DepthModel", "QuadraticDepth", "read_depth_model"]
