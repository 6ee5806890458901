"""One settled scene: sample, let physics settle it, check it, and draw again when it does not stand."""

import logging

from warehouse_sim.errors import PlacementError, SettleError
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.physics import settle_scene
from warehouse_sim.physics.settle import SettleReport
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import SceneSpec

ATTEMPTS = 5
"""Draws per scene before the recipe is blamed; each attempt has random streams of its own."""

_log = logging.getLogger(__name__)


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
            return settled, report
        except (PlacementError, SettleError) as error:
            problem = error
            _log.info("scene %d, seed %d, attempt %d: %s", scene_index, seed, attempt, error)
    raise SettleError(
        f"scene {scene_index} of seed {seed} does not stand after {ATTEMPTS} attempts ({problem}); "
        "loosen the recipe's loads or jitter"
    ) from problem
