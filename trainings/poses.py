"""Train, calibrate and bundle the estimators: the recipe of the weights in models/.

python -m trainings.poses [--methods densefusion-depth] [--minutes 120]

What is missing is generated first. Every stage can be interrupted, and goes on when the command is given again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import tyro

from trainings.bundle import bundle
from trainings.data import FOLDER, MORE_CARTONS, PALLETS, ROBUST, TRAINED_ONLY, Data, made
from warehouse_sim.estimators.pose.densefusion.calibrate import calibrate
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig, Preset, TrainConfig, with_preset
from warehouse_sim.estimators.registries import trained_names
from warehouse_sim.estimators.train import train


@dataclass(frozen=True)
class Stage:
    """One training; a later stage begins with the weights of the one before."""

    data: tuple[Data, ...]
    """What it is trained on."""
    config: TrainConfig
    """How."""


FIRST = Stage(
    (*PALLETS, *TRAINED_ONLY, *ROBUST),
    TrainConfig(
        # At 48 px nothing tells a printed side from another.
        loss=LossConfig(symmetry="shape"),
        # A phase of its own, where it helps: see docs/estimators.md.
        refiner_iterations=0,
        max_minutes=None,
        max_steps=16_000,
        batch=32,
        # Half of what prediction takes, and fp32, cost half of a step's processor time.
        points=128,
        precision="32",
        learning_rate=2e-3,
        balance="crops",
        threads=1,
        workers=1,
        validations=6,
    ),
)
SECOND = Stage(
    (*FIRST.data, *MORE_CARTONS),
    replace(FIRST.config, max_steps=2500, points=None, learning_rate=1e-3, balance="classes", validations=2, seed=1),
)
"""Cartons as often as pallets, and rare SKUs more often than they are."""
ORDER = ("densefusion-depth", "densefusion-pointcloud")
"""Trained first: those that cost least show whether the data are right."""
ONLY_TRAINED_ON = "sampled_pallet_*"
"""Left out of the bundled models: nobody else has these pallets, and each would cost 20 kB."""
_FIRST_FRACTION = 0.85
"""Of the time of a method, for the first stage."""


def in_order(methods: Sequence[str]) -> list[str]:
    """Return the methods, the cheap ones first."""
    return sorted(methods, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER))


def limited(stage: Stage, minutes: float | None, fraction: float, steps: int | None = None) -> TrainConfig:
    """Return how a stage is trained in a fraction of the time that a method has."""
    return replace(
        stage.config,
        max_steps=steps or stage.config.max_steps,
        max_minutes=None if minutes is None else fraction * minutes,
    )


def main(
    folder: Path = FOLDER,
    methods: tuple[str, ...] = (),
    cache: Path | None = None,
    steps: int | None = None,
    minutes: float | None = None,
    generate_only: bool = False,
    bundled: bool = True,
    preset: Preset = "robust",
) -> None:
    """Train what is not trained yet; runs that were interrupted go on.

    Args:
        folder: Where data and runs are kept.
        methods: Which estimators; all by default.
        cache: Where crops are kept; the user's cache folder by default.
        steps: Optimiser steps of the first stage in place of the usual.
        minutes: Most minutes a method trains, both stages; by default the steps alone decide.
        generate_only: Make the data and stop.
        bundled: Put the result into models/.
        preset: robust for masks with errors and tilted cameras; its runs are kept apart.
    """
    if generate_only:
        for item in SECOND.data:
            made(item, folder)
        return
    place = "" if preset == "plain" else f"{preset}/"
    for method in in_order(methods or trained_names()):
        config = with_preset(limited(FIRST, minutes, _FIRST_FRACTION, steps), preset)
        first = _trained(method, config, FIRST.data, folder, f"{place}first", cache)
        config = with_preset(limited(SECOND, minutes, 1.0 - _FIRST_FRACTION), preset)
        run = _trained(method, config, SECOND.data, folder, f"{place}second", cache, init=first)
        calibrate(run, [made(item, folder) for item in FIRST.data])
        if bundled:
            bundle(run, method, first, ONLY_TRAINED_ON)


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
