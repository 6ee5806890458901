"""Scenes as MJCF, the XML of MuJoCo, with meshes and textures in a folder beside it."""

from warehouse_sim.optional import require_extra

require_extra("generate", "to write MJCF")  # one clear line, before the modules below import MuJoCo

from warehouse_sim.interchange.mjcf.carriage import Carriage  # noqa: E402
from warehouse_sim.interchange.mjcf.scene import write_mjcf  # noqa: E402

__all__ = ["Carriage", "write_mjcf"]
