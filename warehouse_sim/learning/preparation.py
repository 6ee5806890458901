"""Turn a dataset folder into what training runs on: crops of both splits and the run's configuration."""

from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.crop_set import CropSet, read_crops, stack_crops
from warehouse_sim.learning.crops import CropConfig
from warehouse_sim.learning.methods import Method
from warehouse_sim.learning.objects import measure_shape
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.run_folder import RunConfig, dataset_digest
from warehouse_sim.learning.settings import TrainConfig


def prepare(
    method: Method, data: Path, config: TrainConfig, progress: Progress | None
) -> tuple[dict[str, CropSet], RunConfig]:
    """Cut all targets of train and val out of the images at ``data`` and measure the objects that occur.

    Raises:
        DatasetError: The folder is no dataset with BOP files.
        TrainingError: A split is empty, or val holds objects that train lacks.
    """
    reader = DatasetReader(data)
    network = method.network(config.size)
    crop = CropConfig(side_px=network.image.side_px if network.image else None)
    found = {}
    for split in ("train", "val"):
        report = _reading(progress, split) if progress else None
        found[split] = read_crops(reader, split, crop, config.seed, config.workers, report)
    known = sorted({item.obj_id for item in found["train"]})
    unknown = sorted({item.obj_id for item in found["val"]} - set(known))
    if unknown:
        raise TrainingError(f"{data}: objects {unknown} of val do not occur in train; generate more scenes")
    rng = np.random.default_rng(config.seed)
    shapes = tuple(measure_shape(reader.objects[obj_id], rng) for obj_id in known)
    crops = {split: stack_crops(items, shapes, crop) for split, items in found.items()}
    name = data.resolve().name
    return crops, RunConfig(method.name, _version(), name, dataset_digest(data), shapes, network, crop, config)


def _reading(progress: Progress, split: str) -> Callable[[float], None]:
    return lambda share: progress(0.0, f"reading {split} {share:.0%}")


def _version() -> str:
    try:
        return version("warehouse-sim")
    except PackageNotFoundError:
        return "not installed"
