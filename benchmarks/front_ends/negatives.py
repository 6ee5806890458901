"""Show estimators look-alikes of pallets, or none that can be taken: how much of it is accepted.

python -m benchmarks.front_ends.negatives [--estimators densefusion-depth rectangle-fit] [--scenes 10] [--write]

The things and the halls are those of ``warehouse-sim bench negatives``, which counts what is rejected in more of them.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tyro

from benchmarks.speed.result import RESULTS, rounded, write_result
from warehouse_sim.benchmark.negatives.score import threshold
from warehouse_sim.benchmark.negatives.things import KINDS, MODEL
from warehouse_sim.benchmark.negatives.trials import Trial, accepted, pallet_info, trials
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.settings import PredictConfig, Refinement
from warehouse_sim.evaluation.intervals import wilson
from warehouse_sim.render import open_renderer

RECIPE, SEED = "industrial", 1921
WITHOUT_STAGES = ("rectangle-fit", "icp-multistart", "front-fit")
"""Trivial and classical methods; they neither choose among predictions nor reject."""
_PLACES = 2
"""In each hall."""


def main(
    estimators: tuple[str, ...] = ("densefusion-depth", "rectangle-fit"),
    refine: Refinement = "icp",
    scenes: int = 10,
    write: bool = False,
    pictures: Path | None = None,
) -> None:
    """Measure all estimators on the same things, those that can also with `--reject-blocked`, and print.

    Args:
        estimators: Chains that find pallets themselves, and estimators, which get the place of the thing.
        refine: As of `predict`, of those that have stages.
        scenes: Halls; twelve things stand in each.
        write: Store the result file.
        pictures: Folder for a picture of each trial, with the scores of the first way.
    """
    ways = {label: way for name in estimators for label, way in opened(name, refine).items()}
    scores: dict[str, dict[str, list[tuple[float, float]]]] = {way: {kind: [] for kind in KINDS} for way in ways}
    with open_renderer("raster") as renderer:
        for trial in (trial for index in range(scenes) for trial in trials(RECIPE, SEED, index, _PLACES, renderer)):
            for label, way in ways.items():
                scores[label][trial.kind].append(accepted(trial, way))
            if pictures is not None:
                _picture(pictures, trial, *scores[next(iter(ways))][trial.kind][-1])
    rows = [row for label, item in scores.items() for row in summary(item, label)]
    for row in rows:
        print(row)
    if write:
        names = " ".join(estimators)
        command = f"python -m benchmarks.front_ends.negatives --estimators {names} --scenes {scenes} --write"
        write_result(RESULTS / "negatives.json", command, rounded(rows), data={"recipe": RECIPE, "seed": SEED})


def opened(name: str, refine: Refinement) -> dict[str, PoseEstimator]:
    """Return an estimator as it is and, where it can reject what is blocked, doing so; by what tables call them."""
    if name.removeprefix("segment-") in WITHOUT_STAGES:
        estimator = load_estimator(name, PredictConfig(objects=(MODEL,)))
        estimator.onboard(pallet_info())
        return {name: estimator}
    config = PredictConfig(selection="consensus", refine=refine, objects=(MODEL,))
    return {
        name: load_estimator(name, config),
        f"{name} --reject-blocked": load_estimator(name, replace(config, reject_blocked=True)),
    }


def summary(scores: dict[str, list[tuple[float, float]]], estimator: str) -> list[dict[str, Any]]:
    """Return how many of each kind are accepted from the score on that accepts 95 of 100 pallets."""
    right = np.array([good for good, _ in scores["pallet"]])
    least = threshold(right.tolist())
    recall = float((right >= least).mean())
    rows: list[dict[str, Any]] = [{"kind": "pallet", "min_score": least, "n": len(right), "value": recall}]
    for kind in KINDS[1:]:
        wrong = np.array([bad for _, bad in scores[kind]])
        fraction = float((wrong >= least).mean())
        rows.append({"kind": kind, "n": len(wrong), "value": fraction})
    named = ({"name": f"{estimator}: {row['kind']}", "estimator": estimator} | row for row in rows)
    return [row | {"interval": list(wilson(row["value"], row["n"]))} for row in named]


def _picture(folder: Path, trial: Trial, right: float, wrong: float) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rgb = cv2.cvtColor(trial.observation.rgbd.rgb, cv2.COLOR_RGB2BGR)
    cv2.putText(rgb, f"{trial.kind} right {right:.2f} wrong {wrong:.2f}", (8, 24), 0, 0.7, (255, 255, 255), 2)
    name = f"{trial.observation.scene_index}_{trial.observation.observation_index}_{trial.kind.replace(' ', '_')}.png"
    cv2.imwrite(str(folder / name), rgb)


if __name__ == "__main__":
    tyro.cli(main)
