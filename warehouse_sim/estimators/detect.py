"""Find objects in all images of a split."""

import time
from dataclasses import replace
from pathlib import Path

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import FoundObject
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.detections import (
    open_stages,
    read_image,
    reads_sweep,
    stage_depth,
    with_depth_of,
    with_sweep,
)
from warehouse_sim.estimators.found_objects import found_object
from warehouse_sim.learning.progress import Progress


def detect(
    names: str, data: Path, split: str, progress: Progress | None = None
) -> tuple[list[FoundObject], list[float]]:
    """Return what is found in the images of ``split``, in their order, and the seconds each image took.

    Args:
        names: Detectors, segmenters, their run folders or files of detections, joined by +, each working on what the
            one before found.
        data: Dataset folder.
        split: "train", "val" or "test".
        progress: Called with the fraction that is done.

    Raises:
        UnknownNameError: A name is none of these.
        DatasetError: The split has no images, or a file of detections was made for another dataset.
        InputError: The dataset lacks what a detector reads.
    """
    reader = DatasetReader(data)
    stages, images = open_stages(names, reader), reader.images(split)
    if not images:
        raise DatasetError(f"{data}: the split {split!r} has no images; choose another with --split")
    found, seconds = list[FoundObject](), list[float]()
    for number, record in enumerate(images):
        image = read_image(reader, record)
        started = time.perf_counter()
        image = with_depth_of(stage_depth(stages), image, reader, record)
        image = with_sweep(image, reader, record) if reads_sweep(stages) else image
        for stage in stages:
            image = replace(image, detections=tuple(stage(image)))
        seconds.append(time.perf_counter() - started)
        found += [found_object(item, image) for item in image.detections]
        if progress:
            progress((number + 1) / len(images), f"{len(found)} found")
    return found, seconds
