"""Trainings on top of an estimator that is there: with its inputs, its size and its disturbances."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.run_config import read_config
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.resources import model_dir


def settings_upon(model: str | Path, data: Sequence[Path], **changes: Any) -> TrainConfig:
    """Return how to go on training a model on datasets: as it was trained, but for ``changes``.

    Args:
        model: Bundled name or run folder.
        data: Dataset folders; objects that the model does not know are left out.
        changes: Settings of the training.
    """
    config = read_config(model_dir(model))
    known = {shape.name for shape in config.objects}
    there = {info.name for folder in data for info in DatasetReader(folder).objects.values()}
    objects = () if there <= known else tuple(sorted(there & known))
    return replace(config.train, **({"objects": objects, "phase": "joint"} | changes))
