"""One scene, ready to be observed: drawn and settled, seen from where the recipe asks for, lit, with its twins."""

from dataclasses import dataclass
from typing import Any

from warehouse_sim.generation.drawn import draw_scene
from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.occlusion import OcclusionReport, request_views
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.twins import Variant, make_variants
from warehouse_sim.generation.twins.config import overlaid
from warehouse_sim.physics.settle import SettleReport
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.layouts.site import Truck
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True, eq=False)
class PreparedScene:
    """A scene with its twins."""

    variants: tuple[Variant, ...]
    """The scene itself first."""
    settle: SettleReport
    """How it came to rest."""
    occlusion: OcclusionReport | None
    """How requests for a visible fraction were met; None when there were none."""
    truck: Truck
    """What takes pallets in its aisle."""

    @property
    def scene(self) -> SceneSpec:
        """The scene itself."""
        return self.variants[0].scene


def prepare_scene(recipe: Recipe, seed: int, scene_index: int) -> PreparedScene:
    """Return scene ``scene_index`` of the dataset with everything that an observation needs.

    Raises:
        SettleError: No attempt gave a scene that stands.
        RecipeError: The light that is asked for cannot be reached.
    """
    drawn = draw_scene(recipe, seed, scene_index)
    camera, settings = recipe.sensors.make_camera(), drawn.settings
    scene, caster, occlusion = drawn.scene, RayCaster(drawn.scene), None
    if recipe.occlusion is not None:
        rng = drawn.stream("occlusion")
        scene, occlusion = request_views(scene, settings, camera, recipe.occlusion, caster, rng)
    if len(scene.instances) > len(drawn.scene.instances):
        caster = RayCaster(scene)

    def relight(dark: SceneSpec, changed: dict[str, Any]) -> SceneSpec:
        lights = overlaid(settings.lights, changed, f"{recipe.name}: twins.lights")
        return light_scene(dark, lights, caster, camera, drawn.stream("lighting"))

    sensor = recipe.sensors.draw_sensor(drawn.stream("sensor"))
    occluders = [() for _ in scene.viewpoints] if occlusion is None else [item.placed for item in occlusion.requests]
    variants = make_variants(relight(scene, {}), recipe.twins, sensor, occluders, relight)
    return PreparedScene(variants, drawn.report, occlusion, settings.layout.truck)
