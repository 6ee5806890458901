"""What a network's own refiner brings, trained as the paper trains it: alone, on top of the network that is there.

    python -m benchmarks.estimators.refiner densefusion-depth densefusion-pointcloud --write

A phase of ``steps`` steps trains the refiner of each bundled estimator on the industrial data; poses with and without
it are compared on that data's test split, before ICP and after. What was trained or scored before is not done again.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.estimators.data import FOLDER, ROBUST, SCORED, made
from benchmarks.estimators.over_seeds import applies, passed
from benchmarks.estimators.score import DOCKING_RANGE, Setting, score
from benchmarks.estimators.upon import settings_upon
from benchmarks.result import RESULTS, write_result
from warehouse_sim.estimators.pose.densefusion.run_config import read_config
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.intervals import scene_bootstrap
from warehouse_sim.resources import model_dir

METHODS = ("densefusion-depth", "densefusion-pointcloud")
METRICS = ("add_10pct", "add_5pct", "add_2pct", "dock_0mm", "dock_0mm_2_7m")
_REFINE = {"consensus": "none", "consensus + ICP": "icp"}
_DRAWS = 2000


def main(
    methods: tyro.conf.Positional[tuple[str, ...]] = METHODS,
    folder: Path = FOLDER,
    iterations: tuple[int, ...] = (1, 2, 4),
    steps: int = 3000,
    learning_rate: float = 2e-3,
    robust: bool = False,
    cache: Path | None = None,
    write: bool = False,
) -> None:
    """Train refiners on top of bundled estimators, and compare poses with and without their corrections.

    Args:
        methods: Bundled models, or run folders.
        folder: Where data, runs, predictions and scores are kept.
        iterations: Numbers of corrections, each compared with none.
        steps: Optimiser steps of the phase.
        learning_rate: Peak of the main training, of which the phase takes 0.3, as the original.
        robust: Whether to train on the sets of every sensor and mounting, too, as robust weights were.
        cache: Where crops are kept; the user's cache folder by default.
        write: Store the result.
    """
    data, found = made(SCORED[0], folder), list[dict[str, Any]]()
    trained_on = [made(item, folder) for item in (SCORED[0], *(ROBUST if robust else ()))]
    for method in methods:
        run = trained(method, trained_on, folder, steps, learning_rate, cache)
        scores = score(run, data, "test", settings((0, *iterations)), folder / "scores" / "refiner" / run.name)
        for row in rows(Path(method).name, scores, iterations):
            found.append(row)
            low, high = row["difference_interval"]
            print(f"{row['name']:70} {row['value']:.3f} {row['difference']:+.3f} [{low:+.3f}, {high:+.3f}]", flush=True)
    if write:
        options = f"{' '.join(methods)} --steps {steps}{' --robust' * robust}"
        write_result(
            RESULTS / "refiner.json",
            f"python -m benchmarks.estimators.refiner {options} --write",
            found,
            data=f"{SCORED[0].recipe} test, seed {SCORED[0].seed}; the refiner trained alone for {steps} steps",
            intervals="of the difference from no correction, 95 %: bootstrap over scenes",
        )


def trained(
    method: str, data: Sequence[Path], folder: Path, steps: int, learning_rate: float, cache: Path | None
) -> Path:
    """Return the run of a refiner on top of a model; one that is complete is kept, one that was interrupted goes on."""
    run = folder / "runs" / "refiner" / f"{Path(method).name}_{len(data)}_{steps}"
    if not (run / "result.json").is_file():
        config = settings_upon(
            method,
            data,
            phase="refiner",
            refiner_iterations=2,
            max_steps=steps,
            max_minutes=None,
            learning_rate=learning_rate,
            threads=1,
            workers=1,
            validations=3,
        )
        train(_estimator(method), data, run, config, resume=run.exists(), init=method, cache=cache)
    return run


def settings(iterations: Sequence[int]) -> tuple[Setting, ...]:
    """Return the ways of prediction that are compared."""
    return tuple(
        Setting(_name(how, count), PredictConfig(selection="consensus", refine=refine, refiner_iterations=count))
        for how, refine in _REFINE.items()
        for count in iterations
    )


def rows(method: str, scores: Mapping[str, Scores], iterations: Sequence[int]) -> list[dict[str, Any]]:
    """Return what each number of corrections changes, as rows of a result file."""
    found = []
    for how in _REFINE:
        bare = scores[_name(how, 0)]
        for count in iterations:
            for metric in METRICS:
                with_it, without = _passed(scores[_name(how, count)], metric), _passed(bare, metric)
                scenes = bare.table.scene_id[_counted(bare, metric)]
                low, high = scene_bootstrap(with_it - without, scenes, _DRAWS, np.random.default_rng(0))
                found.append(
                    {
                        "name": f"{method}, {how}, {count} corrections: {metric}",
                        "method": method,
                        "setting": how,
                        "iterations": count,
                        "metric": metric,
                        "value": round(float(with_it.mean()), 5),
                        "without": round(float(without.mean()), 5),
                        "difference": round(float((with_it - without).mean()), 5),
                        "difference_interval": [round(low, 5), round(high, 5)],
                        "n": len(with_it),
                    }
                )
    return found


def _counted(scores: Scores, metric: str) -> np.ndarray:
    """Tell for each object whether a metric counts it."""
    if metric != "dock_0mm_2_7m":
        return applies(scores, metric)
    low, high = DOCKING_RANGE
    return applies(scores, "dock_0mm") & (scores.table.distance >= low) & (scores.table.distance < high)


def _passed(scores: Scores, metric: str) -> np.ndarray:
    if metric != "dock_0mm_2_7m":
        return passed(scores, metric)
    return passed(scores, "dock_0mm")[_counted(scores, metric)[applies(scores, "dock_0mm")]]


def _name(how: str, count: int) -> str:
    return f"{how} {count}"


def _estimator(method: str) -> str:
    """Return the registered name of a model."""
    return read_config(model_dir(method)).estimator


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
