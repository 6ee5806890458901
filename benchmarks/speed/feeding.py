"""Trainings on a stream that one process makes: how much of the time they wait for it, from their own results."""

import json
import tempfile
from pathlib import Path
from typing import Any

import torch

from benchmarks.speed.subject import Settings
from warehouse_sim.api.training import train
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

_METHODS = ("densefusion-depth", "detector-depth")
_STEPS, _QUICK_STEPS = 384, 8
_FRESH = 0.25
"""As by default."""
_VAL = {
    "scene": {"observations_per_scene": 4},
    "sensors": {"outputs": ["rgb", "depth", "masks", "poses"]},
    "split": {"train": 0.0, "val": 1.0, "test": 0.0},
}


def feeding(settings: Settings) -> dict[str, Any]:
    """Return the row: the fraction of its time that a training waits, once the first window is full."""
    recipe = load_recipe(settings.recipe)
    window = 4 if settings.quick else 2 * recipe.scene.observations_per_scene
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "val"
        scenes = GenerateConfig(scenes=2, seed=settings.seed, formats=("bop",))
        generate(load_recipe(settings.recipe, _VAL), data, scenes)
        methods = {name: _fed(name, data, Path(folder) / name, settings, window) for name in _METHODS}
    return {
        "what": "fraction of a training's time that it waits for its stream, one process making and one training",
        "value": max(method["waited_fraction"] for method in methods.values()),
        "methods": methods,
        "how": "by the wall, since the first window was full, a last validation included; default batch and network",
        "fresh_without_waiting": "of new observations a step, what the maker keeps up with; "
        "more where nothing was waited",
        "window": window,
        "fresh": _FRESH,
        "recipe": recipe.name,
        "threads": torch.get_num_threads(),
    }


def _fed(name: str, data: Path, run: Path, settings: Settings, window: int) -> dict[str, Any]:
    stream = {"recipe": settings.recipe, "seed": settings.seed + 1, "window": window, "fresh": _FRESH}
    steps = _QUICK_STEPS if settings.quick else _STEPS
    train(name, data, run, cache="none", max_minutes=None, max_steps=steps, validations=1, threads=1, stream=stream)
    result = json.loads((run / "result.json").read_text(encoding="utf-8"))
    waited = result["stream_waited_fraction"]
    return {
        "waited_fraction": waited,
        "filling_s": result["stream_filling_seconds"],
        "steps": result["steps"],
        "steps_per_s": result["samples_per_second"] * result["steps"] / result["samples"],
        "fresh_without_waiting": _FRESH * (1.0 - waited),
    }
