"""``warehouse-sim train``: a dataset folder becomes a run folder."""

from pathlib import Path
from typing import Annotated

import tyro

from warehouse_sim.cli.console import finish, say, share_progress
from warehouse_sim.estimators.pose.densefusion.settings import Preset, TrainConfig, with_preset
from warehouse_sim.optional import require_extra


def train(
    estimator: tyro.conf.Positional[str],
    data: tuple[Path, ...],
    out: Path,
    resume: bool = False,
    init: str | None = None,
    cache: Path | None = None,
    preset: Preset = "plain",
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = TrainConfig(),  # noqa: B008  frozen
) -> None:
    """Train an estimator on the train split, watch it on val, and fit there how its confidence predicts its error.

    Test is never read.

    Args:
        estimator: Name of an estimator, see ``warehouse-sim list``.
        data: One or several dataset folders; objects of one number must be one geometry.
        out: Run folder to make: weights, resolved config, curves, result.
        resume: Go on with a run that was interrupted.
        init: Bundled estimator or run folder whose weights training begins with; fresh ones by default.
        cache: Folder that keeps the crops for the next training, by default ``warehouse-sim/crops`` in your cache
            folder; ``none`` keeps them in memory.
        preset: What settings are that are left at their defaults: robust gives the network what is around masks,
            disturbs these and turns clouds upright by gravity; plain trains on true masks in the camera's axes.
        config: How to train.
    """
    require_extra("learn", "to train")
    from warehouse_sim.estimators.train import train as run
    from warehouse_sim.estimators.train import trainable

    method = trainable(estimator)
    with share_progress("training") as progress:
        run(estimator, data, out, with_preset(config, preset), resume, progress, init, cache)
    with share_progress("calibrating") as progress:
        remark = method.calibrate(out, data, progress)
    if remark:
        say(remark)
    finish(out, "predict", out, "--data", data[0], "--out", out / "predictions.csv")
