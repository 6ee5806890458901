"""What each loss does to accuracy and to confidence: eight seeds of each on equal terms.

    python -m benchmarks.estimators.losses [--write]     # trains every loss with every seed; hours on one core

The RMS distance over the symmetry group, ADD-S (nearest points), and Chamfer distances. Runs, calibrations and scores
that are there are kept, so that it goes on where it was interrupted.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.estimators.data import FOLDER, SCORED, made
from benchmarks.estimators.marked import replace_table
from benchmarks.estimators.over_seeds import answer, rounded, seed_interval, standing
from benchmarks.estimators.score import Setting, score
from benchmarks.estimators.study import CONFIG, DOCUMENT, SEEDS
from benchmarks.result import RESULTS, write_result
from warehouse_sim.estimators.pose.densefusion.calibrate import calibrate
from warehouse_sim.estimators.pose.densefusion.calibration import CALIBRATION
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig, TrainConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.selective import auroc

COMMAND = "python -m benchmarks.estimators.losses --write"
LOSSES = {
    "rms": LossConfig(),
    "add-s": LossConfig(symmetry="nearest"),
    "chamfer": LossConfig(distance="chamfer"),
    "chamfer-squared": LossConfig(distance="chamfer-squared"),
    "dissertation": LossConfig(distance="chamfer-squared", unit="metres", confidence_weight=0.015),
}
"""Named as in the tables. The dissertation trains its point cloud method with squared distances in metres."""
TITLES = {
    "rms": "RMS over the symmetry group (default)",
    "add-s": "ADD-S, nearest points",
    "chamfer": "Chamfer",
    "chamfer-squared": "Chamfer, squared",
    "dissertation": "Chamfer, squared, metres, w = 0.015",
}
METRICS = ("add_5pct", "dock_0mm")
MEASURES = {
    "add_5pct": "ADD < 5 % d",
    "dock_0mm": "docked",
    "auroc": "AUROC of the confidence",
    "sure": "confidence above 0.99",
    "bound": "bound holds (90 wanted)",
}
SETTING = Setting("consensus", PredictConfig(selection="consensus", refine="none"))
_SURE = 0.99


def main(
    folder: Path = FOLDER,
    method: str = "densefusion-pointcloud",
    losses: tuple[str, ...] = tuple(LOSSES),
    seeds: tuple[int, ...] = SEEDS,
    config: TrainConfig = CONFIG,
    cache: Path | None = None,
    write: bool = False,
) -> None:
    """Train what is missing, score it, and compare each loss with the default.

    Args:
        folder: Where data, runs and scores are kept.
        method: What is trained; the dissertation has a Chamfer loss for the cloud alone.
        losses: Which of them.
        seeds: One training each.
        config: How each is trained but for loss and seed.
        cache: Where crops are kept; the user's cache folder by default.
        write: Store the result and its table.
    """
    data, found = made(SCORED[0], folder), dict[str, list[Scores]]()
    # Seed by seed: what is interrupted has as many of each loss.
    for seed, name in product(seeds, losses):
        run = folder / "runs" / "losses" / f"{method}-{name}-{config.max_steps}-{seed}"
        settings = replace(config, seed=seed, loss=LOSSES[name])
        found.setdefault(name, []).append(trained_scores(method, run, data, settings, cache))
    rows = [row for name in found for row in measured(name, found[name])]
    answers = [answer(f"{name} in place of rms", found[name], found["rms"], metric)
               for name in found if name != "rms" and "rms" in found for metric in METRICS]  # fmt: skip
    text = as_markdown(rows, answers)
    print(text)
    if write:
        write_result(
            RESULTS / "estimator_losses.json",
            COMMAND,
            rows,
            answers=answers,
            method=method,
            data=f"{SCORED[0].recipe}, seed {SCORED[0].seed}: trained on its train split, bound fitted on val, scored "
            "on test, consensus",
            training={"steps": config.max_steps, "batch": config.batch, "size": config.size, "seeds": list(seeds)},
            intervals="95 %: Student's t over the seeds (of differences: of the same seed's two runs)",
        )
        print(f"output: {replace_table(DOCUMENT, COMMAND, text)}")


def trained_scores(method: str, run: Path, data: Path, config: TrainConfig, cache: Path | None) -> Scores:
    """Return the scores of one training, trained, calibrated and scored where that was not done."""
    if not (run / "result.json").is_file():
        print(f"training {run}", flush=True)
        train(method, data, run, config, resume=run.exists(), cache=cache)
    if not (run / CALIBRATION).is_file():
        calibrate(run, [data], [SETTING.config])
    return score(run, data, "test", (SETTING,), run / "scores")[SETTING.name]


def measured(name: str, scores: Sequence[Scores]) -> list[dict[str, Any]]:
    """Return what a loss's trainings reach, as rows of a result file: mean and interval over the seeds."""
    found = []
    for measure in MEASURES:
        # Of a training that gets nothing right, or all, nobody can say how it ranks.
        values = [value for item in scores if not np.isnan(value := value_of(item, measure))]
        if not values:
            continue
        low, high = seed_interval(values)
        found.append(
            {
                "name": f"{name}: {measure}",
                "loss": name,
                "measure": measure,
                "value": round(float(np.mean(values)), 5),
                "interval": rounded((max(low, 0.0), min(high, 1.0))),
                "seeds": rounded(values),
            }
        )
    return found


def value_of(scores: Scores, measure: str) -> float:
    """Return one measure of one training, 0-1.

    ``auroc``: how well confidence ranks poses within 5 % of the diameter before others. ``sure``: fraction of estimates
    that are sure of themselves, whatever they are. ``bound``: fraction of errors below the bound that val was to make
    hold for nine of ten.
    """
    if measure in METRICS:
        return float(scores.overall.metrics[measure])
    table = scores.table.select(scores.table.found)
    if measure == "auroc":
        return auroc(table.score, table.add < 0.05 * table.diameter)
    if measure == "sure":
        return float((table.score > _SURE).mean())
    return float((table.surface_rms <= table.error_bound).mean())


def as_markdown(rows: Sequence[dict[str, Any]], answers: Sequence[dict[str, Any]]) -> str:
    """Return means with intervals over seeds, and below them which differences from the default stand out."""
    lines = ["| loss | " + " | ".join(MEASURES.values()) + " |", "|---|" + "---|" * len(MEASURES)]
    for name in dict.fromkeys(row["loss"] for row in rows):
        by_measure = {row["measure"]: row for row in rows if row["loss"] == name}
        lines.append(f"| {TITLES[name]} | " + " | ".join(_cell(by_measure.get(key)) for key in MEASURES) + " |")
    lines.append("")
    for metric in METRICS:
        evaluated = [row for row in answers if row["metric"] == metric]
        for row, stands in zip(evaluated, standing(evaluated), strict=True):
            low, high = row["difference_interval"]
            told = "" if stands else ", not told from chance"
            difference = f"{100 * row['difference']:+.1f} points [{100 * low:+.1f}, {100 * high:+.1f}]{told}"
            lines.append(f"- {row['question']}, {MEASURES[metric]}: {difference}")
    return "\n".join(lines)


def _cell(row: dict[str, Any] | None) -> str:
    if row is None:
        return "-"
    low, high = row["interval"]
    return f"{100 * row['value']:.1f} [{100 * low:.1f}, {100 * high:.1f}]"


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
