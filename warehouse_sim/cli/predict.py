"""``warehouse-sim predict``: a trained estimator and a dataset become a file of poses."""

from pathlib import Path
from typing import Annotated

import tyro

from warehouse_sim.cli.console import finish, fraction_progress
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.optional import require_extra


def predict(
    run: tyro.conf.Positional[str],
    data: Path,
    out: Path,
    split: str = "test",
    pictures: Path | None = None,
    config: Annotated[PredictConfig, tyro.conf.arg(name="")] = PredictConfig(),  # noqa: B008  frozen
) -> None:
    """Estimate the pose of every detected object and write the BOP pose CSV, with covariances and bounds beside it.

    Args:
        run: Run folder of a trained estimator, the name of a bundled one, or of one that needs no training.
        data: Dataset folder.
        out: CSV file to write.
        split: Split to predict on.
        pictures: Folder for a picture of each image with the poses in it.
        config: Where detections come from, how a pose is selected and refined.
    """
    require_extra("learn", "to predict")
    from warehouse_sim.dataset.results import predictions
    from warehouse_sim.estimators.predict import predict as estimate

    with fraction_progress("predicting") as progress:
        estimates = estimate(run, data, split, config, progress, pictures)
    predictions.write(out, estimates)
    print(f"calibration: {config.calibration}")
    if config.reject is not None:
        print(f"rejected: {sum(item.rejected for item in estimates)} of {len(estimates)} estimates")
    finish(out, "evaluate", out, "--data", data, "--split", split, "--out", out.with_suffix(""))
