"""What is measured: a scene of a recipe, seen by the recipe's camera from the recipe's viewpoints."""

from dataclasses import dataclass
from typing import Any

from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True)
class Settings:
    """How much is measured."""

    recipe: str = "selective_rack"
    """Name or path of the recipe that scenes are drawn from."""
    seed: int = 0
    """Seed of the scenes, >= 0."""
    quick: bool = False
    """Measure once and little: shows that everything runs, and gives no numbers to quote."""


@dataclass(frozen=True, eq=False)
class Subject:
    """One scene and how it is looked at."""

    recipe: Recipe
    scene: SceneSpec
    camera: PinholeCamera
    views: tuple[Transform, ...]
    """T_world_camera of each view."""

    def facts(self) -> dict[str, Any]:
        """Return the sizes that cost depends on."""
        return scene_facts(self.scene) | {"size_wh": [self.camera.width, self.camera.height], "views": len(self.views)}


def render_subject(settings: Settings, scene_index: int = 0) -> Subject:
    """Return a scene of the settings' recipe, settled and lit."""
    recipe = load_recipe(settings.recipe)
    scene = prepare_scene(recipe, settings.seed, scene_index).scene
    views = tuple(viewpoint.T_world_camera for viewpoint in scene.viewpoints)
    return Subject(recipe, scene, recipe.sensors.make_camera(), views[:2] if settings.quick else views)


def scene_facts(scene: SceneSpec) -> dict[str, Any]:
    """Return the numbers of instances, parts, triangles and lights of a scene."""
    models = [scene.model_of(instance) for instance in scene.instances]
    return {
        "instances": len(models),
        "parts": sum(len(model.parts) for model in models),
        "triangles": sum(len(part.mesh.faces) for model in models for part in model.parts),
        "lights": len(scene.lights),
        "lights_with_shadow": sum(light.casts_shadow for light in scene.lights),
    }
