"""Estimate the poses of a split's targets, or find the objects in its images."""

import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.results.detections import FoundObject
from warehouse_sim.errors import DatasetError, InputError, TrainingError, UnknownNameError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.detections import (
    AUTO,
    GT,
    Finder,
    found_object,
    needs_depth,
    open_stages,
    read_image,
    with_depth_of,
    with_sweep,
)
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pipeline import passed
from warehouse_sim.estimators.pose.icp.oracle import OracleIcp
from warehouse_sim.estimators.predict.pictures import known_sizes, write_pictures
from warehouse_sim.estimators.settings import IMAGES_AT_ONCE, PredictConfig
from warehouse_sim.estimators.tracking.drives import tracked
from warehouse_sim.learning.settings import Progress
from warehouse_sim.schema import PoseEstimate

log = logging.getLogger(__name__)


def predict(
    run: Path | str | object,
    data: str | Path | DatasetReader,
    split: str,
    config: PredictConfig = PredictConfig(),  # noqa: B008  frozen
    progress: Progress | None = None,
    pictures: str | Path | None = None,
) -> list[PoseEstimate]:
    """Estimate what is detected in the images of ``split``, in their order.

    With the ground-truth masks for detections, that is every target that the estimator knows and that is visible
    enough.

    Args:
        run: What ``load_estimator`` takes: a name, a run folder, "file.py:Class", an object or a function.
        data: Dataset folder with BOP files, or an open reader of one.
        split: Name of a split, or "all".
        config: Settings.
        progress: Called with the fraction that is done.
        pictures: Folder for a picture of each image with the poses in it; none by default.

    Returns:
        Poses with the trust in them as score, the seconds spent on the image without reading it as time, and the
        target's position among the image's labels, or the number of what was detected, as detection.

    Raises:
        UnknownNameError: No estimator, detector or segmenter has that name.
        TrainingError: The run is incomplete or knows none of the split's objects.
        DatasetError: The folder is no dataset with BOP files, or states no calibration, but is requested it.
        EstimatorError: A user's own estimator raises an error.
        InputError: A user's own estimator returns something else than estimates.
        InputError: Tracks are requested, but nothing has a covariance, or images do not say where the camera is.
    """
    reader = (
        data.calibrated(config.calibration)
        if isinstance(data, DatasetReader)
        else DatasetReader(data, config.calibration)
    )
    estimator, finder = (
        load_estimator(run, config),
        Finder(config.detections, config.gravity, config.depth, config.objects),
    )
    images = reader.images(split)
    if not images:
        there = [name for name in reader.splits if reader.images(name)]
        raise TrainingError(
            f"{reader.root}: the split {split!r} has no images; "
            f"{' and '.join(there) or 'no split'} {'has' if len(there) < 2 else 'have'} some: "
            "choose another split, or all of them (--split all, split='all')"
        )
    if estimator.objects is None:
        _require_names(config.objects, [info.name for info in reader.objects.values()])
    estimator.onboard(reader.objects)
    if isinstance(estimator, OracleIcp):
        # Whatever else finds objects numbers them in its own way.
        if config.detections not in (AUTO, GT):
            raise InputError("oracle-icp starts at the poses of the labels: leave --detections out, or say gt")
        estimator.show(images)
    # Numbers of objects in a third-party folder are that folder's own, and of no matter to what finds objects itself.
    if reader.manifest is not None or finder.takes_gt(estimator):
        require_known(estimator, reader, images)
    estimates: list[PoseEstimate] = []
    for start in range(0, len(images), IMAGES_AT_ONCE):
        group = images[start : start + IMAGES_AT_ONCE]
        estimates += _estimate(estimator, reader, group, finder)
        if progress:
            progress((start + len(group)) / len(images), f"{len(estimates)} poses")
    if not estimates:
        log.warning("%s: no pose was estimated in the %d images of split %s", reader.root, len(images), split)
    estimates = tracked(reader, split, estimates) if config.track else estimates
    if pictures is not None:
        write_pictures(Path(pictures), reader, images, estimates, known_sizes(estimator, reader))
    return estimates


def require_known(estimator: PoseEstimator, reader: DatasetReader, images: Sequence[ImageRecord]) -> None:
    """Check that the estimator knows a target of some images, and each number it knows under the same name.

    Raises:
        TrainingError: It does not.
    """
    if estimator.objects is None:
        return
    known = {shape.obj_id: shape.name for shape in estimator.objects}
    names = ", ".join(f"{number} {name}" for number, name in known.items())
    requested = {
        obj_id: reader.objects[obj_id].name
        for obj_id in sorted({target.obj_id for image in images for target in image.targets if target.has_pose})
    }
    for obj_id, name in requested.items():
        if known.get(obj_id, name) != name:
            raise TrainingError(f"the run was not trained on object {obj_id} {name}; it knows: {names}")
    left_out = [name for obj_id, name in requested.items() if obj_id not in known]
    if requested and len(left_out) == len(requested):
        raise TrainingError(f"the run was trained on none of {', '.join(left_out)}; it knows: {names}")
    if left_out:
        log.warning("%s: no estimates of what the run was not trained on: %s", reader.root, ", ".join(left_out))


def _require_names(given: Sequence[str], known: list[str]) -> None:
    """Check that a dataset has objects of some names.

    Raises:
        UnknownNameError: It has none of a name.
    """
    for name in given:
        if name not in known:
            raise UnknownNameError("object of the dataset under --objects", name, known)


def read_images(
    estimator: PoseEstimator, reader: DatasetReader, images: Sequence[ImageRecord], detections: str = GT
) -> Iterator[RgbdImage]:
    """Yield those images in which something is detected that the estimator takes."""
    finder = Finder(detections)
    for image in images:
        if found := finder.find(estimator, reader, image):
            yield found


def _estimate(
    estimator: PoseEstimator, reader: DatasetReader, images: Sequence[ImageRecord], finder: Finder
) -> list[PoseEstimate]:
    """Return the poses in some images, whose time counts the detection."""
    found, seconds = list[RgbdImage](), dict[tuple[int, int], float]()
    for record in images:
        if image := finder.find(estimator, reader, record):
            found.append(image)
            seconds[image.scene_id, image.image_id] = finder.seconds
    estimates = estimator.estimate_all(found)
    return [
        replace(item, time=item.time + seconds[item.scene_id, item.image_id]) if item.time >= 0 else item
        for item in estimates
    ]


def detect(
    names: str, data: Path, split: str, progress: Progress | None = None, min_score: float | None = None
) -> tuple[list[FoundObject], list[float]]:
    """Return what is found in the images of ``split``, in their order, and the seconds each image took.

    Args:
        names: Detectors, segmenters, their run folders or files of detections, joined by +, each working on what the
            one before found.
        data: Dataset folder.
        split: "train", "val" or "test".
        progress: Called with the fraction that is done.
        min_score: As ``open_stages`` takes it.

    Raises:
        UnknownNameError: A name is none of these.
        DatasetError: The split has no images, or a file of detections was made for another dataset.
        InputError: The dataset lacks what a detector reads.
    """
    reader = DatasetReader(data)
    stages, images = open_stages(names, reader, min_score=min_score), reader.images(split)
    if not images:
        raise DatasetError(f"{data}: the split {split!r} has no images; choose another with --split")
    found, seconds = list[FoundObject](), list[float]()
    for number, record in enumerate(images):
        image = read_image(reader, record, needs_depth(stages, stages[0].depth_source))
        started = time.perf_counter()
        image = with_depth_of(stages[0].depth_source, image, reader, record)
        image = with_sweep(image, reader, record) if any(stage.reads_sweep for stage in stages) else image
        image = passed(image, stages)
        seconds.append(time.perf_counter() - started)
        found += [found_object(item, image) for item in image.detections]
        if progress:
            progress((number + 1) / len(images), f"{len(found)} found")
    return found, seconds
