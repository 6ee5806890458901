"""One scene, ready to be observed: sampled until it stands, settled, with viewpoints, light and paired variants."""

import logging
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from warehouse_sim.annotate.dockable import dockable_headings
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.errors import PlacementError, SettleError
from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.occlusion import OcclusionReport, request_views
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.recipe.paired_variants import Variant, make_variants, overlaid
from warehouse_sim.physics import SettleReport, settle_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import SceneRecipe, sample_scene, scene_rng
from warehouse_sim.scene.layouts.site import Truck
from warehouse_sim.scene.viewpoints.choose import replace_blocked_views, view_dockable
from warehouse_sim.schema import SceneSpec

ATTEMPTS = 5
"""Draws per scene before the recipe is blamed; each attempt has random streams of its own."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class SampledScene:
    """A settled scene and what it was sampled by."""

    scene: SceneSpec
    """With its final poses, not lit yet."""
    settings: SceneRecipe
    """Its recipe with the one value that each random setting has in this scene."""
    report: SettleReport
    """How it came to rest."""

    def stream(self, stage: str) -> np.random.Generator:
        """Return the random stream of a later stage of this scene."""
        return scene_rng(self.scene.seed, self.scene.scene_index, stage, self.scene.attempt)


def sample_settled_scene(recipe: Recipe, seed: int, scene_index: int) -> SampledScene:
    """Draw scene ``scene_index`` of the dataset with this seed until it stands.

    Raises:
        SettleError: No attempt gave a scene that stands.
    """
    problem: Exception | None = None
    for attempt in range(ATTEMPTS):
        stream = partial(scene_rng, seed, scene_index, attempt=attempt)
        try:
            settings = recipe.scene.sampled(stream)
            drafted = sample_scene(settings, seed, scene_index, attempt)
            settled, report = settle_scene(drafted, recipe.settle)
            report.require_ok()
            scene = replace_blocked_views(settled, settings.viewpoints, stream("renewed viewpoints"))
            if settings.viewpoints.dockable_fraction:
                headings = dockable_headings(scene, TRUCKS[settings.layout.truck])
                scene = view_dockable(scene, headings, settings.viewpoints, stream("dockable viewpoints"))
            return SampledScene(scene, settings, report)
        except (PlacementError, SettleError) as error:
            problem = error
            _log.info("scene %d, seed %d, attempt %d: %s", scene_index, seed, attempt, error)
    raise SettleError(
        f"scene {scene_index} of seed {seed} does not stand after {ATTEMPTS} attempts ({problem}); "
        "loosen the recipe's loads or jitter"
    ) from problem


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
    caster: RayCaster
    """Rays against the scene itself."""

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

    sensor = recipe.sensors.sample_sensor(sampled.stream("sensor"))
    occluders = [() for _ in scene.viewpoints] if occlusion is None else [item.placed for item in occlusion.requests]
    variants = make_variants(relight(scene, {}), recipe.paired_variants, sensor, occluders, relight)
    return PreparedScene(variants, sampled.report, occlusion, settings.layout.truck, caster)
