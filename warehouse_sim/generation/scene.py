"""One scene, ready to be observed: sampled, settled, with viewpoints, light and paired variants."""

from dataclasses import dataclass
from typing import Any

from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.occlusion import OcclusionReport, request_views
from warehouse_sim.generation.paired_variants import Variant, make_variants
from warehouse_sim.generation.paired_variants.config import overlaid
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.sampled import sample_settled_scene
from warehouse_sim.physics.settle import SettleReport
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.layouts.site import Truck
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True, eq=False)
class PreparedScene:
    """A scene with its paired variants."""

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
        RecipeError: The light that is requested cannot be reached.
    """
    sampled = sample_settled_scene(recipe, seed, scene_index)
    camera, settings = recipe.sensors.make_camera(), sampled.settings
    scene, caster, occlusion = sampled.scene, RayCaster(sampled.scene), None
    if recipe.occlusion is not None:
        rng = sampled.stream("occlusion")
        scene, occlusion = request_views(scene, settings, camera, recipe.occlusion, caster, rng)
    if len(scene.instances) > len(sampled.scene.instances):
        caster = RayCaster(scene)

    def relight(dark: SceneSpec, changed: dict[str, Any]) -> SceneSpec:
        lights = overlaid(settings.lights, changed, f"{recipe.name}: paired variants.lights")
        return light_scene(dark, lights, caster, camera, sampled.stream("lighting"))

    sensor = recipe.sensors.draw_sensor(sampled.stream("sensor"))
    occluders = [() for _ in scene.viewpoints] if occlusion is None else [item.placed for item in occlusion.requests]
    variants = make_variants(relight(scene, {}), recipe.paired_variants, sensor, occluders, relight)
    return PreparedScene(variants, sampled.report, occlusion, settings.layout.truck)
