"""Where the detections of a dataset's images come from: its true masks, or detectors and segmenters by name."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.estimators import DETECTORS, SEGMENTERS, PoseEstimator
from warehouse_sim.estimators.gravity import GravitySource, down_from_floor
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.estimators.visibility import LeastVisible

TRUTH = "truth"


class Finder:
    """Reads images of a dataset with what is detected in them that an estimator can take.

    Args:
        names: "truth", or names of detectors and segmenters joined by +, each working on what the one before found.
        gravity: Who says where down is.

    Raises:
        UnknownNameError: A name is neither of a detector nor of a segmenter.
    """

    def __init__(self, names: str = TRUTH, gravity: GravitySource = "rig") -> None:
        self._gravity = gravity
        self._stages = None if names == TRUTH else [_open(name) for name in names.split("+")]
        self.seconds = 0.0
        """How long the last image's detection took; 0 for the truth."""

    def find(self, estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord) -> RgbdImage | None:
        """Return an image with its detections; None where there are none."""
        if self._stages is None:
            truth = _with_true_masks(estimator, reader, image)
            return None if truth is None else self._with_gravity(truth)
        found = self._with_gravity(RgbdImage.from_dataset(reader, image, ()))
        started = time.perf_counter()
        for stage in self._stages:
            found = replace(found, detections=tuple(stage(found)))
        self.seconds = time.perf_counter() - started
        # Estimates refer to what the detector found, whatever of it is estimated.
        numbered = tuple(_numbered(item, position) for position, item in enumerate(found.detections))
        taken = tuple(item for item in numbered if _is_known(estimator, item))
        return replace(found, detections=taken) if taken else None

    def _with_gravity(self, image: RgbdImage) -> RgbdImage:
        if self._gravity == "rig":
            return image
        if self._gravity == "none":
            return replace(image, gravity=None)
        rng = np.random.default_rng([image.scene_id, image.image_id])
        return replace(image, gravity=down_from_floor(image.camera, image.depth, rng))


def _open(name: str) -> Callable[[RgbdImage], Sequence[Detection]]:
    if name in DETECTORS.names():
        return DETECTORS.get(name)().detect
    if name in SEGMENTERS.names():
        return SEGMENTERS.get(name)().segment
    raise UnknownNameError("detector or segmenter", name, [TRUTH, *DETECTORS.names(), *SEGMENTERS.names()])


def _with_true_masks(estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord) -> RgbdImage | None:
    """Read an image with the masks of those targets that the estimator knows and that are seen well enough, if any."""
    least: LeastVisible = getattr(estimator, "least_visible", LeastVisible())
    known = None if estimator.objects is None else {shape.obj_id for shape in estimator.objects}
    # What has no pose is of an object that nobody named: it is estimated as each that the estimator knows.
    named = [item for item in image.targets if known is None or not item.has_pose or item.obj_id in known]
    targets = [item for item in named if least.takes(item)]
    if not targets:
        return None
    return RgbdImage.from_dataset(reader, image, targets, rgb=getattr(estimator, "reads_rgb", True))


def _is_known(estimator: PoseEstimator, detection: Detection) -> bool:
    if detection.model is None or estimator.objects is None:
        return True
    return any(detection.model in (shape.obj_id, shape.name) for shape in estimator.objects)


def _numbered(detection: Detection, position: int) -> Detection:
    return detection if detection.number is not None else replace(detection, number=position)
