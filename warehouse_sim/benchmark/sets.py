"""The datasets of a suite: made where they are missing, known by the hash of their recipe."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from warehouse_sim.benchmark.kept import digest, folder_for
from warehouse_sim.benchmark.suite import DataConfig
from warehouse_sim.config import to_mapping
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.recipe.extends import overlay
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.version import __version__

_SCORED: dict[str, Any] = {"train": 0.0, "val": 0.0, "test": 1.0, "stratify": []}
_TRAINED_ON: dict[str, Any] = {"train": 0.9, "val": 0.1, "test": 0.0, "stratify": []}
_HASHED = 16
"""Digits of a hash in results."""


@dataclass(frozen=True)
class MadeSet:
    """A dataset, complete on disk, and what it was made of."""

    name: str
    root: Path
    recipe_sha256: str = ""
    """Of the resolved recipe with seed, number of scenes, formats and backend; Empty for third-party data."""
    recipe: str = ""
    """Recipe that it comes from; Empty for third-party data."""
    seed: int | None = None
    """None for third-party data."""


Progress = Callable[[int, int], None]


def made(
    name: str, data: DataConfig, out: Path, workers: int, progress: Progress = lambda done, total: None
) -> MadeSet:
    """Return a dataset, generated first, or completed, where its manifest is missing.

    Args:
        name: Name of the data in the suite.
        data: What it is.
        out: Folder of the benchmark; datasets lie under ``data``.
        workers: Processes that generate.
        progress: Called after each scene.

    Raises:
        RecipeError: The recipe does not take the settings.
        DatasetError: A folder of that name holds something else.
    """
    recipe = recipe_of(name, data, out)
    inputs = {
        "recipe": to_mapping(recipe),
        "seed": data.seed,
        "scenes": data.scenes,
        "formats": list(data.formats),
        "backend": data.backend,
        "backend_options": data.backend_options,
        "version": __version__,
    }
    root = folder_for(out / "data", name, inputs)
    if not (root / "manifest.json").is_file():
        config = GenerateConfig(
            scenes=data.scenes,
            seed=data.seed,
            formats=data.formats,
            backend=data.backend,
            backend_options=data.backend_options,
            # A path tracer uses all processors itself.
            workers=1 if data.backend == "pathtrace" else workers,
            resume=root.exists(),
        )
        generate(recipe, root, config, progress)
    return MadeSet(name, root, digest(inputs)[:_HASHED], data.recipe, data.seed)


def recipe_of(name: str, data: DataConfig, out: Path) -> Recipe:
    """Return the recipe with the suite's settings, which is kept as a file under ``recipes``, as a user would write it.

    Raises:
        RecipeError: The recipe does not take the settings.
    """
    own = {
        "extends": data.recipe if not data.recipe.endswith((".yaml", ".yml")) else str(Path(data.recipe).resolve()),
        "description": f"{data.recipe}, as a suite of the benchmark requires it",
        "scene": {"observations_per_scene": data.observations},
        "split": _TRAINED_ON if data.trained_on else _SCORED,
    }
    folder = out / "recipes"
    make_folder(folder)
    path = folder / f"{name}.yaml"
    text = yaml.safe_dump(overlay(own, data.settings), sort_keys=False)
    write_bytes(path, text.encode("utf-8"))
    return load_recipe(str(path))
