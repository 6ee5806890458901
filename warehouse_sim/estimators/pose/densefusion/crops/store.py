"""All targets of a split as crops, read once and kept on disk."""

import hashlib
import json
import logging
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import stack_arrays
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop, image_crops
from warehouse_sim.learning.samples.array_store import Arrays, joined, kept_arrays

log = logging.getLogger(__name__)


def read_crops(
    reader: DatasetReader,
    split: str,
    config: CropConfig,
    seed: int,
    workers: int,
    progress: Callable[[float], None] | None = None,
) -> Iterator[list[Crop]]:
    """Yield the crops of each image of a split that has any, in their order, decoding in ``workers`` threads.

    Raises:
        TrainingError: The dataset has no such split.
    """
    if split not in reader.splits:
        raise TrainingError(f"{reader.root}: has no split {split!r}; it has: {', '.join(reader.splits) or '(none)'}")
    images = reader.images(split)

    def cut(image: ImageRecord) -> list[Crop]:
        return list(image_crops(reader, image, config, seed))

    count = 0
    with ThreadPoolExecutor(workers) as pool:
        for done, found in enumerate(pool.map(cut, images), start=1):
            count += len(found)
            if found:
                yield found
            if progress:
                progress(done / len(images))
    log.info("%d crops from %d images of %s", count, len(images), split)


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
    """Return the arrays of ``stack_arrays`` for all wanted targets of a split, from the cache if they are there.

    Networks with and without colour or depth share one entry of the cache: each takes the columns it reads.

    Args:
        reader: The dataset.
        split: Which split.
        config: How to cut.
        workers: Threads that decode images.
        cache: Folder to keep crops in; None keeps them in memory.
        progress: Called with the fraction of the images that is read; not called when the crops are found.

    Returns:
        The arrays, or None when the split has no usable target.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
    """
    if cache is None:
        return joined(
            stack_arrays(crops, config) for crops in read_crops(reader, split, config, CUT_SEED, workers, progress)
        )
    whole = replace(config, rgb=True, depth=True) if config.side_px else config
    entry = cache / f"{split}-{crops_digest(reader, split, whole)}"
    chunks = read_crops(reader, split, whole, CUT_SEED, workers, progress)
    arrays = kept_arrays(entry, "crops", (stack_arrays(crops, whole) for crops in chunks))
    unwanted = set() if config.reads_rgb else {"rgb"}
    unwanted |= set() if config.reads_depth else {"depth", "depth_base", "ray_map"}
    return None if arrays is None else {name: array for name, array in arrays.items() if name not in unwanted}


def crops_digest(reader: DatasetReader, split: str, config: CropConfig) -> str:
    """Return a text that changes with anything the crops depend on.

    That is the manifest, the way of cutting, the labels, and names and sizes of the images: a dataset that other code
    regenerated may have the same manifest, but not images of the same sizes.
    """
    digest = hashlib.sha256(json.dumps([reader.digest, _FORMAT, CUT_SEED, split, asdict(config)]).encode())
    for path in reader.files(split):
        labels = path.read_bytes() if path.suffix in (".json", ".txt") else b""
        digest.update(json.dumps([str(path.relative_to(reader.root)), path.stat().st_size]).encode() + labels)
    return digest.hexdigest()[:24]
