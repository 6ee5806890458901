"""Images through a lens: a backend draws what a pinhole sees, and each pixel is looked up where its ray goes."""

from warehouse_sim.render.lens.renderer import LensRenderer
from warehouse_sim.render.lens.source import LensMap, lens_map

__all__ = ["LensMap", "LensRenderer", "lens_map"]
