"""Does memory stay flat: 1,000 observations over 50 scenes in one process, drawn, sensed, labelled and written."""

import os
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from benchmarks.speed.subject import Settings
from warehouse_sim.generation.generate import GenerateConfig, generate
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.processes import end_with_parent

SCENES, OBSERVATIONS_PER_SCENE, WARM_UP = 50, 20, 100
QUICK_SCENES, QUICK_WARM_UP = 2, 20
RECIPE = "demo"
"""Scenes of about one size and quickly made, so that what grows is not the scenes."""


def memory(settings: Settings) -> dict[str, Any]:
    """Return the row; the run has a process of its own, so that nothing else is in its memory."""
    scenes, warm_up = (QUICK_SCENES, QUICK_WARM_UP) if settings.quick else (SCENES, WARM_UP)
    with ProcessPoolExecutor(1, get_context("spawn"), end_with_parent) as pool:
        resident = pool.submit(resident_by_scene, settings, scenes).result()
    first, last = resident[warm_up // OBSERVATIONS_PER_SCENE - 1], resident[-1]
    return {
        "what": f"resident memory after {scenes * OBSERVATIONS_PER_SCENE} observations / after {warm_up}",
        "value": last / first,
        "target": "<= 1.05",
        "first_mib": first,
        "last_mib": last,
        "largest_mib": max(resident),
        "observations": scenes * OBSERVATIONS_PER_SCENE,
        "scenes": scenes,
        "recipe": RECIPE,
        "mib_by_scene": resident,
    }


def resident_by_scene(settings: Settings, scenes: int) -> list[float]:
    """Generate a dataset in this process and return the resident memory (MiB) after each of its scenes."""
    recipe = load_recipe(RECIPE)
    recipe = replace(recipe, scene=replace(recipe.scene, observations_per_scene=OBSERVATIONS_PER_SCENE))
    resident = []
    with tempfile.TemporaryDirectory() as folder:
        config = GenerateConfig(scenes=scenes, seed=settings.seed)
        generate(recipe, Path(folder) / "dataset", config, lambda done, total: resident.append(_resident_mib()))
    return resident[1:]  # the first call comes before the first scene


def _resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
