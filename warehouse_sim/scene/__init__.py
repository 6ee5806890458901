"""From a recipe (a distribution) to a SceneSpec (one draw of it), before physics."""

from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.scene.streams import scene_rng

__all__ = ["Distribution", "SceneRecipe", "sample_scene", "scene_rng"]
