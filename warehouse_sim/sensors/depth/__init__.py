"""Depth cameras: clean depth becomes what a sensor of one kind or another reads of it."""

from warehouse_sim.sensors.depth.model import DepthModel
from warehouse_sim.sensors.depth.models import MODELS, PRESETS
from warehouse_sim.sensors.depth.quadratic import QuadraticDepth

__all__ = ["MODELS", "PRESETS", "DepthModel", "QuadraticDepth"]
