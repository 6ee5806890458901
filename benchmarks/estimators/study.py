"""Does attention help, does colour help, does averaging help: several seeds of each method on equal terms.

python -m benchmarks.estimators.study [--write]     # trains every method with every seed; hours on two cores
"""

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import torch
import tyro
from scipy.stats import t as student_t

from benchmarks.estimators import two_branches
from benchmarks.estimators.data import FOLDER, SCORED, made
from benchmarks.estimators.marked import replace_table
from benchmarks.estimators.score import SELECTIONS, score
from warehouse_sim import train
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.intervals import scene_bootstrap
from warehouse_sim.evaluation.metrics import MetricConfig, pass_values

RESULT = Path(__file__).parents[1] / "results" / "estimator_study.json"
DOCUMENT = Path(__file__).parents[2] / "docs" / "estimators.md"
COMMAND = "python -m benchmarks.estimators.study --write"
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
"""What is asked; the first with its selection against the second with its own."""
_TITLES = {"add_5pct": "ADD < 5 % d", "dock_0mm": "docked"}
METRICS = tuple(_TITLES)
CONFIG = TrainConfig(max_minutes=None, max_steps=600, batch=32, learning_rate=2e-3, threads=1, workers=1, validations=1)
"""Equal samples for all, 4 % of what the bundled weights saw: each method is trained three times."""
_DRAWS = 2000


def main(
    folder: Path = FOLDER,
    seeds: tuple[int, ...] = (0, 1, 2),
    methods: tuple[str, ...] = METHODS,
    config: TrainConfig = CONFIG,
    write: bool = False,
) -> None:
    """Train what is missing, score it, and answer the questions.

    Args:
        folder: Where data, runs and scores are kept; runs that are complete are not trained again.
        seeds: One training each.
        methods: Which methods to train.
        config: How each is trained but for its seed.
        write: Store the result.
    """
    two_branches.register()
    data = made(SCORED[0], folder)
    found: dict[tuple[str, str], list[Scores]] = {}
    for method, seed in product(methods, seeds):
        run = folder / "study" / f"{method}-{seed}"
        if not (run / "result.json").is_file():
            print(f"training {run}")
            train(method, data, run, replace(config, seed=seed), resume=run.exists())
        for name, scores in score(run, data, "test", SELECTIONS, run / "scores").items():
            found.setdefault((method, name), []).append(scores)
    rows = [_value(method, setting, metric, found[method, setting]) for method, setting in found for metric in METRICS]
    answers = [answer(question, found[a], found[b], metric)
               for question, a, b in QUESTIONS for metric in METRICS if a in found and b in found]  # fmt: skip
    for row in rows:
        print(f"{row['name']:60s} {100 * row['value']:5.1f}  {[round(100 * value, 1) for value in row['seeds']]}")
    for row in answers:
        low, high = row["difference_interval"]
        print(
            f"{row['question']:50s} {row['metric']:9s} {100 * row['difference']:+5.1f}  "
            f"[{100 * low:+.1f}, {100 * high:+.1f}] {[round(100 * value, 1) for value in row['seeds']]}"
        )
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
        replace_table(DOCUMENT, COMMAND, as_markdown(answers))
        print(f"output: {RESULT}, {DOCUMENT}")


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


def answer(question: str, first: Sequence[Scores], second: Sequence[Scores], metric: str) -> dict:
    """Return by how much the first trainings pass a metric more often than the second, one of each a seed.

    Both were scored on the same objects.
    """
    # Row by row and seed by seed: what makes a scene hard for both cancels.
    gains = np.stack([passed(a, metric) - passed(b, metric) for a, b in zip(first, second, strict=True)])
    by_seed = gains.mean(axis=1)
    scenes = first[0].table.scene_id[applies(first[0], metric)]
    return {
        "question": question,
        "metric": metric,
        "difference": round(float(by_seed.mean()), 5),
        "difference_interval": _rounded(seed_interval(by_seed)),
        "scenes_interval": _rounded(scene_bootstrap(gains.mean(axis=0), scenes, _DRAWS, np.random.default_rng(0))),
        "seeds": _rounded(by_seed),
    }


def as_markdown(answers: Sequence[dict]) -> str:
    """Return the answers as a Markdown table, in points; bold where both intervals lie on one side of zero."""
    metrics = [metric for metric in METRICS if any(row["metric"] == metric for row in answers)]
    columns = [f"{_TITLES[metric]}: over seeds | over scenes" for metric in metrics]
    lines = ["| question | " + " | ".join(columns) + " |", "|---|" + "---|---|" * len(metrics)]
    for question in dict.fromkeys(row["question"] for row in answers):
        cells = []
        for metric in metrics:
            row = next(row for row in answers if (row["question"], row["metric"]) == (question, metric))
            intervals = (row["difference_interval"], row["scenes_interval"])
            sure = all(low > 0 for low, _ in intervals) or all(high < 0 for _, high in intervals)
            mean, seeds, scenes = f"{100 * row['difference']:+.1f}", *map(_points, intervals)
            cells += [f"{f'**{mean}**' if sure else mean} {seeds}", scenes]
        lines.append(f"| {question} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _points(interval: Sequence[float]) -> str:
    low, high = interval
    return f"[{100 * low:+.1f}, {100 * high:+.1f}]"


def seed_interval(values: Sequence[float]) -> tuple[float, float]:
    """Return Student's 95 % interval for the mean over trainings with other seeds.

    With three of them it is 4.3 standard errors wide on each side (2 degrees of freedom); resampling three values, as a
    bootstrap does, would make it less than half of that.
    """
    mean, count = float(np.mean(values)), len(values)
    if count < 2:
        return -1.0, 1.0  # one training tells nothing: shares and their differences lie between these
    half = student_t.ppf(0.975, count - 1) * float(np.std(values, ddof=1)) / np.sqrt(count)
    return mean - half, mean + half


def passed(scores: Scores, metric: str) -> np.ndarray:
    """Return one value in 0-1 for each object that a metric applies to."""
    return pass_values(scores.table, MetricConfig())[metric][applies(scores, metric)]


def applies(scores: Scores, metric: str) -> np.ndarray:
    """Tell for each object whether a metric applies to it."""
    return ~np.isnan(pass_values(scores.table, MetricConfig())[metric])


def _rounded(values: Sequence[float]) -> list[float]:
    return [round(float(value), 5) for value in values]


if __name__ == "__main__":
    tyro.cli(main)
