"""All targets of a split as crops, read once and kept on disk."""

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import stack_arrays
from warehouse_sim.estimators.pose.densefusion.crops.cut import image_crops
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.split import load_rows, split_digest, split_images

_FORMAT = 2
"""To be raised when the arrays change."""
CUT_SEED = 0
"""Decides which pixels of large targets are kept: one choice for all trainings, so that they share their crops."""


def load_crops(
    reader: DatasetReader,
    split: str,
    config: CropConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> Arrays | None:
    """Return the arrays of ``stack_arrays`` for all wanted targets of a split, or None when it has no usable one.

    Networks with and without colour or depth share one entry of the cache: each takes the columns it reads. Arguments
    and errors are those of ``load_rows``; ``config`` says how to cut.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
    """
    whole = replace(config, rgb=True, depth=True) if config.side_px and cache else config

    def cut(image: ImageRecord) -> Arrays | None:
        crops = list(image_crops(reader, image, whole, CUT_SEED))
        return stack_arrays(crops, whole) if crops else None

    settings = _settings(split, whole)
    arrays = load_rows(reader, split, split_images(reader, split), cut, settings, "crops", workers, cache, progress)
    unwanted = set() if config.reads_rgb else {"rgb"}
    unwanted |= set() if config.reads_depth else {"depth", "depth_base", "ray_map"}
    return None if arrays is None else {name: array for name, array in arrays.items() if name not in unwanted}


def crops_digest(reader: DatasetReader, split: str, config: CropConfig) -> str:
    """Return a text that changes with anything the crops depend on."""
    return split_digest(reader, split, _settings(split, config))


def _settings(split: str, config: CropConfig) -> list[object]:
    return [_FORMAT, CUT_SEED, split, asdict(config)]
