"""Scenes as binary glTF 2.0 for viewers, engines and web pages."""

from warehouse_sim.interchange.glb.scene import write_glb

__all__ = ["write_glb"]
