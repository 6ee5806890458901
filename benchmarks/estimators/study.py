"""Does attention help, does colour help, does averaging help: eight seeds of each method on equal terms.

    python -m benchmarks.estimators.study [--write]     # trains every method with every seed; hours on one core

Runs and scores that are there are kept, so that it goes on where it was interrupted; ``--methods`` and ``--seeds`` do a
part of it, and the answers are those of what is complete.
"""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch
import tyro

from benchmarks.estimators import two_branches
from benchmarks.estimators.data import FOLDER, SCORED, made
from benchmarks.estimators.marked import replace_table
from benchmarks.estimators.over_seeds import answer, as_markdown, seed_interval, sentences
from benchmarks.estimators.score import SELECTIONS, score
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.evaluation import Scores

RESULT = Path(__file__).parents[1] / "results" / "estimator_study.json"
DOCUMENT = Path(__file__).parents[2] / "docs" / "estimators.md"
COMMAND = "python -m benchmarks.estimators.study --write"
CARRIED = (
    "What these intervals carry, with Holm's correction for the number of questions (5 %) and the interval over scenes "
    "on the same side of zero; no other difference in the table is beyond chance:"
)
METHODS = (
    "densefusion-pointcloud",
    "densefusion-depth",
    "densefusion",
    "densefusion-early",
    two_branches.NAME,
    "densefusion-middle-1",
    "densefusion-middle-2",
    "object-coordinates",
)
_COMPARED = (
    ("does colour help", "densefusion", "densefusion-pointcloud"),
    ("does a depth image beside the cloud help", "densefusion-depth", "densefusion-pointcloud"),
    ("does a depth image help more than colour", "densefusion-depth", "densefusion"),
    ("does joining depth to colour help", "densefusion-early", "densefusion"),
    ("does a branch for each image help", two_branches.NAME, "densefusion-early"),
    ("does small attention help", "densefusion-middle-1", two_branches.NAME),
    ("does large attention help more", "densefusion-middle-2", "densefusion-middle-1"),
    ("do correspondences help", "object-coordinates", "densefusion"),
)
QUESTIONS = (
    *(
        (f"{question}, {selection}", (method, selection), (other, selection))
        for question, method, other in _COMPARED
        for selection in ("argmax", "consensus")
    ),
    *(
        (f"does {selection} help {method}", (method, selection), (method, "argmax"))
        for method in METHODS[:3]
        for selection in ("weighted", "weighted-50", "consensus")
    ),
)
"""What is evaluated; the first with its selection against the second with its own."""
METRICS = ("add_5pct", "dock_0mm")
CONFIG = TrainConfig(
    max_minutes=None,
    max_steps=600,
    batch=32,
    learning_rate=2e-3,
    refiner_iterations=0,
    threads=1,
    workers=1,
    validations=1,
)
"""Equal samples for all, a few per cent of what the bundled weights saw: each method is trained many times. The refiner
is a question of its own (benchmarks/estimators/refiner.py)."""
SEEDS = tuple(range(8))


def main(
    folder: Path = FOLDER,
    seeds: tuple[int, ...] = SEEDS,
    methods: tuple[str, ...] = METHODS,
    config: TrainConfig = CONFIG,
    cache: Path | None = None,
    write: bool = False,
) -> None:
    """Train what is missing, score it, and answer the questions.

    Args:
        folder: Where data, runs and scores are kept; runs that are complete are not trained again.
        seeds: One training each.
        methods: Which methods to train.
        config: How each is trained but for its seed.
        cache: Where crops are kept; the user's cache folder by default.
        write: Store the result, the table and the sentences that its intervals carry.
    """
    two_branches.register()
    data = made(SCORED[0], folder)
    found: dict[tuple[str, str], list[Scores]] = {}
    # Seed by seed: what is interrupted has as many of each method.
    for seed, method in product(seeds, methods):
        for name, scores in trained_scores(method, seed, data, folder, config, cache).items():
            found.setdefault((method, name), []).append(scores)
    rows = [_value(method, setting, metric, found[method, setting]) for method, setting in found for metric in METRICS]
    answers = [answer(question, found[a], found[b], metric)
               for question, a, b in QUESTIONS for metric in METRICS if a in found and b in found]  # fmt: skip
    for row in rows:
        print(f"{row['name']:60s} {100 * row['value']:5.1f}  {[round(100 * value, 1) for value in row['seeds']]}")
    print(as_markdown(answers), sentences(answers), sep="\n\n")
    if write:
        result = {
            "machine": {"cores": os.cpu_count(), "torch": torch.__version__},
            "command": COMMAND,
            "data": f"{SCORED[0].recipe}, seed {SCORED[0].seed}: trained on its train split, scored on test",
            "training": {"steps": config.max_steps, "batch": config.batch, "size": config.size, "seeds": list(seeds)},
            "intervals": "95 %: Student's t over the seeds (of differences: of the same seed's two runs); over the "
            "test scenes: bootstrap of the mean over seeds",
            "rows": rows,
            "answers": answers,
        }
        RESULT.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        publish(answers, result["training"])
        print(f"output: {RESULT}, {DOCUMENT}")


def publish(answers: Sequence[dict], training: Mapping[str, Any]) -> None:
    """Put the table, and below it what its intervals carry, into the document."""
    seeds, steps, batch = len(training["seeds"]), training["steps"], training["batch"]
    how = f"{seeds} seeds of each, {steps} steps of {batch} samples, `{training['size']}`:"
    text = "\n\n".join([how, as_markdown(answers), CARRIED, sentences(answers)])
    replace_table(DOCUMENT, COMMAND, text)


def trained_scores(
    method: str, seed: int, data: Path, folder: Path, config: TrainConfig, cache: Path | None
) -> dict[str, Scores]:
    """Return the scores of one training by selection, trained and scored where that was not done."""
    run = folder / "runs" / "study" / f"{method}-{config.max_steps}-{seed}"
    if not (run / "result.json").is_file():
        print(f"training {run}", flush=True)
        train(method, data, run, replace(config, seed=seed), resume=run.exists(), cache=cache)
    return score(run, data, "test", SELECTIONS, run / "scores")


def _value(method: str, setting: str, metric: str, scores: Sequence[Scores]) -> dict:
    values = [item.overall.metrics[metric] for item in scores]
    low, high = seed_interval(values)
    return {
        "name": f"{method}, {setting}: {metric}",
        "value": round(float(np.mean(values)), 5),
        "interval": [round(max(low, 0.0), 5), round(min(high, 1.0), 5)],
        "seeds": [round(value, 5) for value in values],
        "n": scores[0].overall.gt_count,
    }


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
