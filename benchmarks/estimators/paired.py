"""Train on raster images, on path traced ones and on both, and score each on both: which does better on the other.

    python -m benchmarks.estimators.paired --write                          # makes what is missing; hours of paths
    python -m benchmarks.estimators.paired --recipe smoke --samples 1 --steps 10 --seeds 0 --folder out/trial

Both sets are made from the same seeds: the same scenes, views, labels and sensor noise, split alike, so that images
differ in how light was computed and in nothing else. Each training takes as many steps.
"""

import os
from dataclasses import dataclass, replace
from pathlib import Path

import tyro

from benchmarks.estimators.score import SELECTIONS, score
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim import generate, load_recipe, train
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.generation.plan import GenerateConfig

METHOD = "densefusion"
TRAINED_ON = {"raster": ("raster",), "pathtrace": ("pathtrace",), "both": ("raster", "pathtrace")}
METRICS = ("add_5pct", "dock_0mm")
STEPS = 2000
CONFIG = TrainConfig(
    max_minutes=None, max_steps=STEPS, batch=32, learning_rate=2e-3, threads=1, workers=1, validations=2
)


@dataclass(frozen=True)
class Pairs:
    """The two sets: one recipe, one seed, two renderers."""

    recipe: str = "photoreal"
    """Shipped recipe."""
    seed: int = 0
    """Of both."""
    scenes: int | None = None
    """Number of scenes, by default the recipe's."""
    views: int | None = None
    """Observations of each scene, by default the recipe's."""
    samples: int = 16
    """Paths a pixel, denoised."""


def made(pairs: Pairs, backend: str, folder: Path) -> Path:
    """Return the dataset of one backend, generated or completed first if it must be."""
    root = folder / backend
    if not (root / "manifest.json").is_file():
        print(f"generating {root}", flush=True)
        recipe = load_recipe(pairs.recipe)
        views = pairs.views or recipe.scene.observations_per_scene
        options = {"samples": pairs.samples, "denoise": True} if backend == "pathtrace" else {}
        # The path tracer uses all cores itself.
        workers = 1 if options else os.cpu_count() or 1
        config = GenerateConfig(
            scenes=pairs.scenes,
            seed=pairs.seed,
            formats=("bop",),
            backend=backend,
            backend_options=options,
            workers=workers,
            resume=root.exists(),
        )
        generate(replace(recipe, scene=replace(recipe.scene, observations_per_scene=views)), root, config)
    return root


def main(
    recipe: str = Pairs.recipe,
    folder: Path = Path("out/paired"),
    scenes: int | None = None,
    views: int | None = None,
    samples: int = 16,
    steps: int = STEPS,
    seeds: tuple[int, ...] = (0, 1, 2),
    write: bool = False,
) -> None:
    """Make both sets, train on one, the other and both, and score each on the test scenes of both.

    Args:
        recipe: Shipped recipe.
        folder: Where data and runs are kept; what is complete is not made again.
        scenes: Number of scenes, by default the recipe's.
        views: Observations of each scene, by default the recipe's.
        samples: Paths a pixel.
        steps: Optimiser steps of each training.
        seeds: One training each.
        write: Store the result.
    """
    pairs = Pairs(recipe, scenes=scenes, views=views, samples=samples)
    data = {name: made(pairs, name, folder) for name in ("raster", "pathtrace")}
    rows = []
    for name, sources in TRAINED_ON.items():
        for seed in seeds:
            run = folder / "runs" / f"{name}-{seed}"
            if not (run / "result.json").is_file():
                config = replace(CONFIG, max_steps=steps, seed=seed)
                train(METHOD, [data[item] for item in sources], run, config, resume=run.exists())
            for other, root in data.items():
                scores = score(run, root, "test", SELECTIONS[-1:], run / other)[SELECTIONS[-1].name]
                values = {metric: scores.overall.metrics[metric] for metric in METRICS}
                title = f"trained on {name}, scored on {other}, seed {seed}"
                rows += [{"name": f"{title}: {metric}", "value": value} for metric, value in rounded(values).items()]
                print(title, values, flush=True)
    if write:
        command = (
            f"python -m benchmarks.estimators.paired --recipe {recipe} --samples {samples} --steps {steps} --write"
        )
        how = {"recipe": pairs.recipe, "seed": pairs.seed, "scenes": scenes, "views": views, "method": METHOD}
        write_result(RESULTS / "paired.json", command, rows, data=how)


if __name__ == "__main__":
    tyro.cli(main)
