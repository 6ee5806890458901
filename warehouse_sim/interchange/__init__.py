"""Scenes for other programs: USD for simulators and film tools, GLB for viewers."""

from warehouse_sim.interchange.glb import write_glb
from warehouse_sim.interchange.usd import write_usd

__all__ = ["write_glb", "write_usd"]
