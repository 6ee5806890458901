"""``warehouse-sim train``: a dataset folder becomes a run folder."""

from pathlib import Path
from typing import Annotated

import tyro

from warehouse_sim.cli.console import finish, share_progress
from warehouse_sim.learning.settings import TrainConfig


def train(
    estimator: tyro.conf.Positional[str],
    data: Path,
    out: Path,
    resume: bool = False,
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = TrainConfig(),  # noqa: B008  frozen
) -> None:
    """Train an estimator on the train split and watch it on val; test is never read.

    Args:
        estimator: Name of an estimator, see ``warehouse-sim list``.
        data: Dataset folder.
        out: Run folder to make: weights, resolved config, curves, result.
        resume: Go on with a run that was interrupted.
        config: How to train.
    """
    from warehouse_sim.learning.train import train as run

    with share_progress("training") as progress:
        run(estimator, data, out, config, resume, progress)
    finish(out, "predict", out, "--data", data, "--out", out / "predictions.csv")
