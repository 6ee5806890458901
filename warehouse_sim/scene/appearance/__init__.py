"""What the surfaces of a scene look like: paint, age, dirt and gloss, drawn by the recipe."""

from warehouse_sim.scene.appearance.config import AppearanceConfig
from warehouse_sim.scene.appearance.painting import paint_scene
from warehouse_sim.scene.appearance.palettes import PaintConfig

__all__ = ["AppearanceConfig", "PaintConfig", "paint_scene"]
