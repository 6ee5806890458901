"""What an estimator says of the images of a dataset, some of it disturbed before it sees them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warehouse_sim.benchmark.disturbances.by_name import UNNAMED, disturbance
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.detections import Finder
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.predict import require_known
from warehouse_sim.schema import PoseEstimate


def answers(
    way: Way, reader: DatasetReader, split: str, disturb: str, progress: Callable[[float, str], None]
) -> list[PoseEstimate]:
    """Return the estimates of a split's images, in their order.

    Where nobody names the object, those of the dataset that the estimator knows are what it may be. Times count the
    detection, as those of ``predict`` do.

    Args:
        way: The estimator and its settings.
        reader: The dataset.
        split: Which images.
        disturb: Name of what is done to each image; it has a random stream of its own.
        progress: Called with the fraction that is done.

    Raises:
        UnknownNameError: No such estimator or disturbance.
        TrainingError: There are no weights, or they know no object of the split.
    """
    config, change = way.config, disturbance(disturb)
    if config.calibration != reader.calibration:
        reader = DatasetReader(reader.root, config.calibration)
    estimator, images = way.open(reader.objects), reader.images(split)
    require_known(estimator, reader, images)
    may_be = _candidates(estimator, reader) if disturb == UNNAMED else ()
    finder = Finder(config.detections, config.gravity, config.depth, config.objects)
    found: list[PoseEstimate] = []
    for start in range(0, len(images), config.images_at_once):
        group = images[start : start + config.images_at_once]
        seen, seconds = list[RgbdImage](), dict[tuple[int, int], float]()
        for record in group:
            if (image := finder.find(estimator, reader, record)) is None:
                continue
            rng = np.random.default_rng([image.scene_id, image.image_id])
            seen.append(_as_one_of(change(image, rng), may_be))
            seconds[image.scene_id, image.image_id] = finder.seconds
        found += [_with_time(item, seconds) for item in _estimated(estimator, seen)]
        progress((start + len(group)) / len(images), f"{len(found)} poses")
    return found


def _estimated(estimator: PoseEstimator, images: list[RgbdImage]) -> list[PoseEstimate]:
    return estimator.estimate_all(images) if images else []


def _with_time(item: PoseEstimate, seconds: dict[tuple[int, int], float]) -> PoseEstimate:
    return replace(item, time=item.time + seconds[item.scene_id, item.image_id]) if item.time >= 0 else item


def _candidates(estimator: PoseEstimator, reader: DatasetReader) -> tuple[int, ...]:
    if estimator.objects is None:
        return ()
    return tuple(sorted({shape.obj_id for shape in estimator.objects} & set(reader.objects)))


def _as_one_of(image: RgbdImage, may_be: tuple[int, ...]) -> RgbdImage:
    if not may_be:
        return image
    return replace(image, detections=tuple(replace(item, may_be=may_be) for item in image.detections))
