"""Scenes as OpenUSD: geometry, textures, lights, cameras, physics and labels out, and the same scene back in."""

from warehouse_sim.interchange.usd.read import read_usd
from warehouse_sim.interchange.usd.write import write_usd

__all__ = ["read_usd", "write_usd"]
