"""Scenes for other programs: USD for simulators and film tools, GLB for viewers."""

from warehouse_sim.interchange.glb import write_glb
from warehouse_sim.interchange.usd import read_usd, write_usd

__all__ = ["read_usd", "write_glb", "write_usd"]
