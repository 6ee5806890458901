"""``warehouse-sim predict``: an estimator and a dataset become a file of poses."""

import shlex
from pathlib import Path
from typing import Annotated, Any

import tyro

from warehouse_sim.cli.checks import require_free
from warehouse_sim.cli.console import finish, fraction_progress
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.optional import require_extra

_TIMEOUT = 60.0


def predict(
    run: tyro.conf.Positional[str | None] = None,
    *,
    data: Path,
    out: Path,
    split: str = "test",
    pictures: Path | None = None,
    overwrite: bool = False,
    exec: str | None = None,
    exec_timeout: float = _TIMEOUT,
    config: Annotated[PredictConfig, tyro.conf.arg(name="")] = PredictConfig(),  # noqa: B008  frozen
) -> None:
    """Estimate the pose of every detected object and write the BOP pose CSV, with covariances and bounds beside it.

    Args:
        run: A bundled estimator, a run folder, one that needs no training, or your own: ``file.py:Class`` or
            ``module:Class``.
        data: Dataset folder.
        out: CSV file to write.
        split: Split to predict on, or all.
        pictures: Folder for a picture of each image with the poses in it.
        overwrite: Replace the CSV file where there is one.
        exec: In place of an estimator, a program that reads images and writes poses as JSON lines (docs/estimators.md).
        exec_timeout: Seconds that the program may take for an image, above 0.
        config: Where detections come from, how a pose is selected and refined.
    """
    require_extra("learn", "to predict")
    from warehouse_sim.api.scoring import predict as estimate
    from warehouse_sim.estimators.own.program import ProgramEstimator

    if (run is None) == (exec is None):
        raise InputError("predict takes an estimator or --exec COMMAND; see warehouse-sim list estimators")
    require_free(out, overwrite)
    if exec is None and exec_timeout != _TIMEOUT:
        raise InputError("--exec-timeout is of the program of --exec; leave it out")
    if not 0.0 < exec_timeout <= 86_400.0:
        raise InputError(f"--exec-timeout must be above 0 and at most 86400 s, found {exec_timeout:g}")
    command = _command(run, exec, data, out, split, config)
    estimator: Any = run if exec is None else ProgramEstimator(exec, exec_timeout)
    try:
        with fraction_progress("predicting") as progress:
            estimates = estimate(estimator, data, out, split, pictures, progress, command, **vars(config))
    finally:
        if isinstance(estimator, ProgramEstimator):
            estimator.close()
    print(f"calibration: {config.calibration}")
    if config.reject is not None:
        print(f"rejected: {sum(item.rejected for item in estimates)} of {len(estimates)} estimates")
    finish(out, "evaluate", out, "--data", data, "--split", split, "--out", out.with_suffix(""))


def _command(run: str | None, exec: str | None, data: Path, out: Path, split: str, config: PredictConfig) -> str:
    """Return the command line that gives these predictions, defaults left out."""
    words = ["warehouse-sim", "predict", *([run] if run else []), *(["--exec", exec] if exec else [])]
    words += ["--data", str(data), "--out", str(out), "--split", split]
    for name, value in vars(config).items():
        if value != getattr(PredictConfig(), name):
            option = name.replace("_", "-")
            if isinstance(value, bool):
                words.append(f"--{option}" if value else f"--no-{option}")
            else:
                words += [f"--{option}", *(map(str, value) if isinstance(value, tuple) else [str(value)])]
    return shlex.join(words)
