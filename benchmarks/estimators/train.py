"""Train, calibrate and bundle the estimators: the recipe of the weights in models/.

python -m benchmarks.estimators.train [--methods densefusion]    # a quarter of an hour to an hour a method on one core
"""

from dataclasses import dataclass, replace
from pathlib import Path

import tyro

from benchmarks.estimators.bundle import bundle
from benchmarks.estimators.data import FOLDER, MORE_CARTONS, SCORED, TRAINED_ONLY, Data, made
from warehouse_sim import train
from warehouse_sim.estimators import trained_names
from warehouse_sim.estimators.pose.densefusion.calibrate import calibrate
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig


@dataclass(frozen=True)
class Stage:
    """One training; a later stage begins with the weights of the one before."""

    data: tuple[Data, ...]
    """What it is trained on."""
    config: TrainConfig
    """How."""


FIRST = Stage(
    (*SCORED, *TRAINED_ONLY),
    TrainConfig(
        max_minutes=None,
        max_steps=12_000,
        batch=32,
        learning_rate=2e-3,
        balance="crops",
        threads=1,
        workers=1,
        validations=6,
    ),
)
SECOND = Stage(
    (*FIRST.data, *MORE_CARTONS),
    replace(FIRST.config, max_steps=2500, learning_rate=1e-3, balance="classes", validations=2, seed=1),
)
"""Cartons as often as pallets, and rare SKUs more often than they are."""


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
        steps: Optimiser steps of the first stage in place of the usual.
    """
    for method in methods or trained_names():
        config = replace(FIRST.config, max_steps=steps or FIRST.config.max_steps)
        first = _trained(method, config, FIRST.data, folder, "first", cache)
        run = _trained(method, SECOND.config, SECOND.data, folder, "second", cache, init=first)
        # The two sets of cartons that were there first have enough of them in val.
        calibrate(run, [made(item, folder) for item in (*SCORED, TRAINED_ONLY[-1])])
        bundle(run, method, first)


def _trained(
    method: str,
    config: TrainConfig,
    data: tuple[Data, ...],
    folder: Path,
    stage: str,
    cache: Path | None,
    init: Path | None = None,
) -> Path:
    run = folder / "runs" / stage / method
    if not (run / "result.json").is_file():
        folders = [made(item, folder) for item in data]
        train(method, folders, run, config, resume=run.exists(), cache=cache, init=init)
    return run


if __name__ == "__main__":
    tyro.cli(main)
