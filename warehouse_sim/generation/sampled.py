"""One draw of a recipe that stands: its settings are sampled once a scene, and travel with the scene from here on."""

import logging
from dataclasses import dataclass
from functools import partial

import numpy as np

from warehouse_sim.errors import PlacementError, SettleError
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.physics import SettleReport, settle_scene
from warehouse_sim.scene import SceneRecipe, sample_scene, scene_rng
from warehouse_sim.scene.viewpoints.choose import replace_blocked_views
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
            return SampledScene(scene, settings, report)
        except (PlacementError, SettleError) as error:
            problem = error
            _log.info("scene %d, seed %d, attempt %d: %s", scene_index, seed, attempt, error)
    raise SettleError(
        f"scene {scene_index} of seed {seed} does not stand after {ATTEMPTS} attempts ({problem}); "
        "loosen the recipe's loads or jitter"
    ) from problem
