"""Where cameras look from: single views and drives of vehicles, and free cameras, with their targets in view."""

from warehouse_sim.scene.viewpoints.choose import choose_viewpoints, views_of
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints

__all__ = ["FreeSpace", "ViewpointsConfig", "candidate_viewpoints", "choose_viewpoints", "shows", "views_of"]
