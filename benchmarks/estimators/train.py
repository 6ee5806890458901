"""Train, calibrate and bundle the estimators: the recipe of the weights in models/.

python -m benchmarks.estimators.train [--methods densefusion]    # about a quarter of an hour a method on one core
"""

from dataclasses import replace
from pathlib import Path

import tyro

from benchmarks.estimators.bundle import bundle
from benchmarks.estimators.data import FOLDER, SCORED, TRAINED_ONLY, made
from warehouse_sim import train
from warehouse_sim.estimators.calibrate import calibrate
from warehouse_sim.learning.methods import ESTIMATORS
from warehouse_sim.learning.settings import TrainConfig

STEPS = {"densefusion-pointcloud": 9000, "densefusion": 6000}
"""Where it differs from the default: these two cost least a step."""
CONFIG = TrainConfig(
    max_minutes=None,
    max_steps=4000,
    batch=32,
    learning_rate=2e-3,
    balance="crops",
    threads=1,
    workers=1,
    validations=6,
)


def main(
    folder: Path = FOLDER,
    methods: tuple[str, ...] = (),
    cache: Path | None = None,
    steps: int | None = None,
) -> None:
    """Train what is not trained yet; runs that were interrupted go on.

    Args:
        folder: Where data and runs are kept.
        methods: Which estimators; all by default.
        cache: Where crops are kept; the user's cache folder by default.
        steps: Optimiser steps in place of the usual.
    """
    data = [made(item, folder) for item in (*SCORED, *TRAINED_ONLY)]
    for method in methods or ESTIMATORS.names():
        run = folder / "runs" / method
        if not (run / "result.json").is_file():
            config = replace(CONFIG, max_steps=steps or STEPS.get(method, CONFIG.max_steps))
            train(method, data, run, config, resume=run.exists(), cache=cache)
        # Cartons are in the val splits of the training data only.
        calibrate(run, [*data[: len(SCORED)], data[-1]])
        bundle(run, method)


if __name__ == "__main__":
    tyro.cli(main)
