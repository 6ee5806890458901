"""What a network's own refiner brings: the bundled weights with it and without it.

python -m benchmarks.estimators.refiner [--write]     # after python -m benchmarks.estimators
"""

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
import tyro
import yaml

from benchmarks.estimators.data import FOLDER, SCORED, made
from benchmarks.estimators.score import SETTINGS, score
from warehouse_sim.config import to_mapping
from warehouse_sim.estimators.pose.densefusion.run_config import read_config
from warehouse_sim.evaluation.intervals import scene_bootstrap
from warehouse_sim.evaluation.metrics import MetricConfig, pass_values
from warehouse_sim.learning.run_folder import CONFIG
from warehouse_sim.resources import data_folder

RESULT = Path(__file__).parents[1] / "results" / "refiner.json"
METHODS = ("densefusion-depth", "densefusion-pointcloud")
METRICS = ("add_10pct", "add_5pct", "add_2pct", "dock_0mm")
_SETTING = SETTINGS[1]


def main(folder: Path = FOLDER, methods: tuple[str, ...] = METHODS, write: bool = False) -> None:
    """Score ``methods`` on industrial's test split with consensus, with the refiner of their training and without any.

    Args:
        folder: Where data, predictions and scores are kept.
        methods: Names of bundled models.
        write: Store the result.
    """
    data, rows = made(SCORED[0], folder), []
    for method in methods:
        model = data_folder("models") / method
        bare = _without_refiner(model, folder / "without-refiner" / method)
        place = folder / "scores" / method / SCORED[0].folder_name
        with_it = score(model, data, "test", SETTINGS, place)[_SETTING.name]
        without = score(bare, data, "test", (_SETTING,), bare / "scores")[_SETTING.name]
        for metric in METRICS:
            refined, plain = (pass_values(scores.table, MetricConfig())[metric] for scores in (with_it, without))
            low, high = scene_bootstrap(refined - plain, with_it.table.scene_id, 1000, np.random.default_rng(0))
            rows.append(
                {
                    "name": f"{method}, {_SETTING.name}: {metric}",
                    "value": round(float(refined.mean()), 5),
                    "without": round(float(plain.mean()), 5),
                    "difference_interval": [round(low, 5), round(high, 5)],
                    "n": len(refined),
                }
            )
            print(rows[-1])
    if write:
        result = {
            "machine": {"cores": os.cpu_count(), "torch": torch.__version__},
            "command": "python -m benchmarks.estimators.refiner --write",
            "data": f"{SCORED[0].recipe} test, seed {SCORED[0].seed}; 2 iterations of the refiner against none",
            "intervals": "of the difference, 95 %: bootstrap over scenes",
            "rows": rows,
        }
        RESULT.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        print(f"output: {RESULT}")


def _without_refiner(model: Path, folder: Path) -> Path:
    """Return a copy of the model that runs no iteration of its refiner."""
    shutil.copytree(model, folder, dirs_exist_ok=True)
    config = read_config(model)
    bare = replace(config, train=replace(config.train, refiner_iterations=0))
    (folder / CONFIG).write_text(yaml.safe_dump(to_mapping(bare), sort_keys=False), encoding="utf-8")
    return folder


if __name__ == "__main__":
    tyro.cli(main)
