"""One scene, ready to be observed: sampled, settled, seen from where the recipe asks for, lit, with its twins."""

import logging
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from warehouse_sim.errors import PlacementError, SettleError
from warehouse_sim.generation.lighting import light_scene
from warehouse_sim.generation.occlusion import OcclusionReport, request_views
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.twins import Variant, make_variants
from warehouse_sim.generation.twins.config import overlaid
from warehouse_sim.physics import settle_scene
from warehouse_sim.physics.settle import SettleReport
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.scene.viewpoints.after_settling import renew_lost_views
from warehouse_sim.schema import SceneSpec

ATTEMPTS = 5
"""Draws per scene before the recipe is blamed; each attempt has random streams of its own."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class PreparedScene:
    """A scene with its twins."""

    variants: tuple[Variant, ...]
    """The scene itself first."""
    settle: SettleReport
    """How it came to rest."""
    occlusion: OcclusionReport | None
    """How requests for a visible fraction were met; None when there were none."""

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
    scene, report = settled_scene(recipe, seed, scene_index)
    attempt = scene.attempt

    def stream(stage: str) -> np.random.Generator:
        return scene_rng(seed, scene_index, stage, attempt)

    drawn, camera = recipe.scene.drawn(stream), recipe.sensors.make_camera()
    caster, occlusion, before = RayCaster(scene), None, scene.instances
    if recipe.occlusion is not None:
        scene, occlusion = request_views(scene, drawn, camera, recipe.occlusion, caster, stream("occlusion"))
    occluders = [item.instance_id for item in scene.instances[len(before) :]]
    if occluders:
        caster = RayCaster(scene)

    def relight(dark: SceneSpec, settings: dict[str, Any]) -> SceneSpec:
        lights = overlaid(drawn.lights, settings, f"{recipe.name}: twins.lights")
        return light_scene(dark, lights, caster, camera, stream("lighting"))

    variants = make_variants(relight(scene, {}), recipe.twins, recipe.sensors.rgbd, occluders, relight)
    return PreparedScene(variants, report, occlusion)


def settled_scene(recipe: Recipe, seed: int, scene_index: int) -> tuple[SceneSpec, SettleReport]:
    """Return scene ``scene_index`` of the dataset with its final poses, and how it came to rest.

    Raises:
        SettleError: No attempt gave a scene that stands.
    """
    problem: Exception | None = None
    for attempt in range(ATTEMPTS):
        try:
            spec = sample_scene(recipe.scene, seed, scene_index, attempt)
            settled, report = settle_scene(spec, recipe.settle)
            report.require_ok()
            drawn = recipe.scene.drawn(partial(scene_rng, seed, scene_index, attempt=attempt))
            rng = scene_rng(seed, scene_index, "renewed viewpoints", attempt)
            return renew_lost_views(settled, drawn.viewpoints, rng), report
        except (PlacementError, SettleError) as error:
            problem = error
            _log.info("scene %d, seed %d, attempt %d: %s", scene_index, seed, attempt, error)
    raise SettleError(
        f"scene {scene_index} of seed {seed} does not stand after {ATTEMPTS} attempts ({problem}); "
        "loosen the recipe's loads or jitter"
    ) from problem
