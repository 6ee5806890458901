"""Answers to the fixed subset of a dataset, object by object within a time, so that slow methods can be scored."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from warehouse_sim.benchmark.entrants.ways import Way, opened
from warehouse_sim.benchmark.groups import fixed_subset, ground_truths, places_of
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.own.program import ProgramEstimator, TooSlowError
from warehouse_sim.geometry.boxes import box_ious, mask_box_xyxy
from warehouse_sim.schema import PoseEstimate


def subset_answers(
    way: Way,
    reader: DatasetReader,
    split: str,
    limit: float,
    progress: Callable[[float, str], None],
    kept: Path | None = None,
) -> list[PoseEstimate]:
    """Return the estimates of the objects of the fixed subset, in order of the images.

    Of an image an estimator gets one detection at a time: that which overlaps a pallet of the subset most. One that
    finds objects itself gets the image, and the time of all pallets of the subset in it. The first object comes
    twice, so that no start counts. The time of an image is that of its objects, detection included.

    Args:
        way: The estimator and its settings.
        reader: The dataset.
        split: Which images.
        limit: Seconds that an object may take; what takes longer is missed.
        progress: Called with the fraction that is done.
        kept: Where what detectors find is kept; None keeps nothing.

    Raises:
        UnknownNameError: No such estimator.
        TrainingError: There are no weights, or they know no object of the split.
    """
    estimator, finder, reader = opened(way, reader, split, kept)
    wanted, found = wanted_objects(reader, split), list[PoseEstimate]()
    is_warm = False
    for number, (record, targets) in enumerate(wanted):
        progress(number / len(wanted), f"{len(found)} poses")
        if (image := finder.find(estimator, reader, record)) is None:
            continue
        questions = [(image, limit * len(targets))] if not image.detections else _alone(image, targets, limit)
        mine, seconds = list[PoseEstimate](), finder.seconds
        for question, allowed in questions:
            with suppress(TooSlowError):
                if not is_warm:
                    estimator.estimate_all([question])
                is_warm = True
                started = time.perf_counter()
                answer = estimator.estimate_all([question])
                took = time.perf_counter() - started
                mine += answer if took <= allowed else []
                seconds += took
            if _is_ended(estimator):
                estimator, is_warm = way.open(reader.objects), False
        found += [replace(item, time=seconds) for item in mine]
    return found


def wanted_objects(reader: DatasetReader, split: str) -> list[tuple[ImageRecord, list[TargetRecord]]]:
    """Return the images that show pallets of the fixed subset, with these."""
    table = ground_truths(reader, split)
    chosen = set(places_of(table.select(fixed_subset(table))))
    images = (
        (image, [item for item in image.targets if (image.scene_id, image.image_id, item.gt_index) in chosen])
        for image in reader.images(split)
    )
    return [(image, targets) for image, targets in images if targets]


def _alone(image: RgbdImage, targets: Sequence[TargetRecord], limit: float) -> list[tuple[RgbdImage, float]]:
    """Return the image with each detection alone that overlaps one of the targets most, and the time for it."""
    boxes = np.array([_box(item) for item in image.detections], dtype=float)
    gt = np.array([item.box_visible_xyxy for item in targets], dtype=float)
    overlap = box_ious(boxes, gt)
    best = {int(overlap[:, column].argmax()) for column in range(len(targets)) if overlap[:, column].max() > 0.0}
    return [(replace(image, detections=(image.detections[row],)), limit) for row in sorted(best)]


def _box(item: Detection) -> tuple[float, float, float, float]:
    if item.box_xyxy is not None:
        return item.box_xyxy
    box = None if item.mask is None else mask_box_xyxy(item.mask)
    return (0.0, 0.0, 0.0, 0.0) if box is None else box


def _is_ended(estimator: PoseEstimator) -> bool:
    """Return whether an estimator is a program that was ended because it took too long."""
    return isinstance(estimator, ProgramEstimator) and estimator.is_ended
