"""What a paired variant in another light costs, against an observation of a new scene."""

import statistics
import time
from dataclasses import replace
from typing import Any

from benchmarks.speed.subject import Settings
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.recipe.paired_variants import PairedVariantsConfig
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.render.renderer import Renderer

RECIPE = "lighting_study"


def paired_variants(settings: Settings) -> dict[str, Any]:
    """Return the row: medians over scenes of all that is done in memory; files are not written."""
    recipe = load_recipe(RECIPE)
    alone = replace(recipe, paired_variants=PairedVariantsConfig())
    count = recipe.scene.observations_per_scene
    others = count * (len(recipe.paired_variants.names()) - 1)
    new, paired_variant = [], []
    with open_renderer("raster") as renderer:
        _observe(alone, settings.seed, 0, renderer)  # compiles shaders, loads textures
        for index in range(1, 2 if settings.quick else 4):
            first = _observe(alone, settings.seed, index, renderer)
            both = _observe(recipe, settings.seed, index, renderer)
            new.append(first / count)
            paired_variant.append((both - first) / others)
    ours, fresh = statistics.median(paired_variant), statistics.median(new)
    return {
        "what": f"a paired variant in another light ({RECIPE}), against an observation of a new scene",
        "ours_cpu_s": ours,
        "new_observation_cpu_s": fresh,
        "fraction": ours / fresh,
        "scenes": len(new),
        "note": "sampling, settling, lighting, drawing, sensing and labelling; no files",
    }


def _observe(recipe: Recipe, seed: int, index: int, renderer: Renderer) -> float:
    """Return the CPU time (s) of one scene from nothing to its last observation."""
    start = time.process_time()
    prepared = prepare_scene(recipe, seed, index)
    for _ in observe_scene(prepared.scene, recipe.sensors, renderer, prepared.variants):
        pass
    return time.process_time() - start
