"""Train on raster images, on path traced ones and on both, and score each on both: which does better on the other.

    python -m benchmarks.estimators.paired --write                          # makes what is missing; hours of paths
    python -m benchmarks.estimators.paired --recipe benchmarks/estimators/paired_small.yaml --samples 4 --steps 10

Both sets are made from the same seeds: the same scenes, views, labels and sensor noise, split alike, so that images
differ in how light was computed and in nothing else. Each training takes as many steps.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import tyro

from benchmarks.estimators.marked import replace_table
from benchmarks.estimators.over_seeds import answer, applies, as_markdown, passed
from benchmarks.estimators.score import SELECTIONS, score
from benchmarks.estimators.study import DOCUMENT
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

METHOD = "densefusion"
TRAINED_ON = {"raster": ("raster",), "pathtrace": ("pathtrace",), "both": ("raster", "pathtrace")}
METRICS = ("add_5pct", "add_10pct", "dock_0mm")
STEPS = 2000
CONFIG = TrainConfig(
    max_minutes=None, max_steps=STEPS, batch=32, learning_rate=2e-3, threads=1, workers=1, validations=2
)
QUESTIONS = (
    ("path traced images in place of raster ones, scored on path traced", "pathtrace", "raster", "pathtrace"),
    ("raster images in place of path traced ones, scored on raster", "raster", "pathtrace", "raster"),
    ("both in place of raster images alone, scored on path traced", "both", "raster", "pathtrace"),
    ("both in place of path traced images alone, scored on raster", "both", "pathtrace", "raster"),
)
"""What is evaluated: does training on the second help, against training on the third, when scored on the fourth."""
SMALL = Path(__file__).with_name("paired_small.yaml")
"""A recipe of few small images, for where hours of paths are too many."""
MARK = "python -m benchmarks.estimators.paired"

Found = Mapping[tuple[str, str], Sequence[Scores]]
"""Scores of each training's seeds, by what was trained and what was scored on."""


@dataclass(frozen=True)
class Pairs:
    """The two sets: one recipe, one seed, two renderers."""

    recipe: str = "photoreal"
    """Shipped recipe, or a file."""
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
        recipe: Shipped recipe, or a file.
        folder: Where data and runs are kept; what is complete is not regenerated.
        scenes: Number of scenes, by default the recipe's.
        views: Observations of each scene, by default the recipe's.
        samples: Paths a pixel.
        steps: Optimiser steps of each training.
        seeds: One training each.
        write: Store the result.
    """
    pairs = Pairs(recipe, scenes=scenes, views=views, samples=samples)
    data = {name: made(pairs, name, folder) for name in ("raster", "pathtrace")}
    found: dict[tuple[str, str], list[Scores]] = {}
    for name, seed in product(TRAINED_ON, seeds):
        run = folder / "runs" / f"{name}-{seed}"
        if not (run / "result.json").is_file():
            config = replace(CONFIG, max_steps=steps, seed=seed)
            train(METHOD, [data[item] for item in TRAINED_ON[name]], run, config, resume=run.exists())
        for other, root in data.items():
            scores = score(run, root, "test", SELECTIONS[-1:], run / other)[SELECTIONS[-1].name]
            found.setdefault((name, other), []).append(scores)
    rows, answers = fractions(found), differences(found)
    for row in (*rows, *answers):
        print(row, flush=True)
    if write:
        chosen = {"recipe": recipe, "scenes": scenes, "views": views, "samples": samples, "steps": steps}
        options = [f"--{key} {value}" for key, value in chosen.items() if value is not None]
        command = " ".join([MARK, *options, "--seeds", *map(str, seeds), "--write"])
        how = {"recipe": recipe, "seed": pairs.seed, **_sizes(data["raster"])}
        training = {"method": METHOD, "steps": steps, "batch": CONFIG.batch, "size": CONFIG.size, "seeds": list(seeds)}
        write_result(RESULTS / "paired.json", command, rows, data=how, training=training, answers=answers)
        replace_table(DOCUMENT, MARK, as_markdown(answers))


def fractions(found: Found) -> list[dict]:
    """Return for each training, test set and metric the mean over seeds, with a 95 % interval over test scenes."""
    rows = []
    for ((name, other), scores), metric in product(found.items(), METRICS):
        each = np.stack([passed(item, metric) for item in scores])
        if not each.size:
            continue  # nothing in sight can be docked
        scenes = scores[0].table.scene_id[applies(scores[0], metric)]
        row = {
            "name": f"trained on {name}, scored on {other}: {metric}",
            "value": float(each.mean()),
            "interval": fraction_interval(each.mean(axis=0), scenes, 2000, np.random.default_rng(0)),
            "seeds": [float(value) for value in each.mean(axis=1)],
            "n": each.shape[1],
        }
        rows.append(rounded(row))
    return rows


def differences(found: Found) -> list[dict]:
    """Return the answers to the questions, with intervals over seeds and over test scenes."""
    return [
        rounded(answer(question, found[first, scored], found[second, scored], metric))
        for question, first, second, scored in QUESTIONS
        for metric in METRICS
        if applies(found[first, scored][0], metric).any()
    ]


def _sizes(root: Path) -> dict[str, int]:
    """Return how many scenes and images a dataset has, and how many of them each split."""
    reader = DatasetReader(root)
    images = {split: reader.images(split) for split in ("train", "val", "test")}
    counts = {f"images of {split}": len(found) for split, found in images.items()}
    scenes = {f"scenes of {split}": len({image.scene_id for image in found}) for split, found in images.items()}
    return {**scenes, **counts}


if __name__ == "__main__":
    tyro.cli(main)
