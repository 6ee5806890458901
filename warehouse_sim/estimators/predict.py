"""Estimate the targets of a split with a trained run."""

import logging
from collections.abc import Iterator, Sequence
from pathlib import Path

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.estimator import Estimator, load_estimator
from warehouse_sim.estimators.rgbd_image import RgbdImage
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.learning.crops import wanted_targets
from warehouse_sim.learning.progress import Progress
from warehouse_sim.schema import PoseEstimate

log = logging.getLogger(__name__)


def predict(
    run: Path | str, data: Path, split: str, config: PredictConfig, progress: Progress | None = None
) -> list[PoseEstimate]:
    """Estimate every target of ``split`` that the run knows and that is visible enough, in order of images.

    Args:
        run: Run folder of a trained estimator, or the name of a bundled one.
        data: Dataset folder with BOP files.
        split: "train", "val" or "test".
        config: Settings.
        progress: Told the share that is done.

    Returns:
        Poses with the network's confidence as score, the seconds spent on the image without reading it as time, and
        the target's position among the image's labels as detection.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
        TrainingError: The run is incomplete or knows none of the split's objects.
        DatasetError: The folder is no dataset with BOP files.
    """
    reader = DatasetReader(data)
    estimator = load_estimator(run, config)
    images = reader.images(split)
    if not images:
        raise TrainingError(f"{data}: the split {split!r} has no images; generate more scenes")
    require_known(estimator, reader, images)
    estimates: list[PoseEstimate] = []
    for start in range(0, len(images), config.images_at_once):
        group = images[start : start + config.images_at_once]
        estimates += estimator.estimate_all(list(read_images(estimator, reader, group)))
        if progress:
            progress((start + len(group)) / len(images), f"{len(estimates)} poses")
    return estimates


def require_known(estimator: Estimator, reader: DatasetReader, images: Sequence[ImageRecord]) -> None:
    """Check that the estimator knows a target of some images, and each number it knows under the same name.

    Raises:
        TrainingError: It does not.
    """
    known = {shape.obj_id: shape.name for shape in estimator.objects}
    names = ", ".join(f"{number} {name}" for number, name in known.items())
    asked = {
        obj_id: reader.objects[obj_id].name
        for obj_id in sorted({target.obj_id for image in images for target in image.targets})
    }
    for obj_id, name in asked.items():
        if known.get(obj_id, name) != name:
            raise TrainingError(f"the run was not trained on object {obj_id} {name}; it knows: {names}")
    left_out = [name for obj_id, name in asked.items() if obj_id not in known]
    if asked and len(left_out) == len(asked):
        raise TrainingError(f"the run was trained on none of {', '.join(left_out)}; it knows: {names}")
    if left_out:
        log.warning("%s: no estimates of what the run was not trained on: %s", reader.root, ", ".join(left_out))


def read_images(estimator: Estimator, reader: DatasetReader, images: Sequence[ImageRecord]) -> Iterator[RgbdImage]:
    """Yield those images that show a known target well enough, with the true masks of such targets."""
    known = {shape.obj_id for shape in estimator.objects}
    for image in images:
        targets = [target for target in wanted_targets(image, estimator.crop) if target.obj_id in known]
        if targets:
            yield RgbdImage.from_dataset(reader, image, targets, rgb=estimator.reads_rgb)
