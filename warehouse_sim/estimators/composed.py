"""From pixels to poses in one call: a pose estimator behind what finds the objects of images that name none."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.api import PoseEstimator, WrappedEstimator
from warehouse_sim.estimators.chain import FindDetections
from warehouse_sim.estimators.detections import open_stages
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.matching import known_among, taken_by
from warehouse_sim.estimators.pose.keypoints.estimator import KeypointEstimator
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import model_dir, model_names
from warehouse_sim.schema import PoseEstimate


class WithFrontEnd(WrappedEstimator):
    """A pose estimator that finds the objects of an image itself, where the image brings no detections.

    Args:
        estimator: What estimates the poses of what is found.
        stages: What finds it, one after the other.
        objects: Names of the objects that there are; by default those that it is shown, and all that the estimator
            knows before it is shown any.
    """

    finds_objects = True
    reads_rgb = True

    def __init__(self, estimator: PoseEstimator, stages: Sequence[FindDetections], objects: Sequence[str] = ()) -> None:
        super().__init__(estimator)
        self._stages = tuple(stages)
        self._given = self._names = tuple(objects)

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take what is found for one of these objects, by obj_id, unless their names were given."""
        self.inner.onboard(objects)
        self._names = self._given or known_among(self.inner, objects)

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return the poses of what the image brings, or of what is found in it; times count the finding."""
        return self.estimate_all([image])

    def estimate_all(self, images: Sequence[RgbdImage]) -> list[PoseEstimate]:
        """Return what ``estimate`` returns for each image, one after the other."""
        found, seconds = list[RgbdImage](), dict[tuple[int, int], float]()
        for image in images:
            started = time.perf_counter()
            found.append(image if image.detections else self._with_detections(image))
            seconds[image.scene_id, image.image_id] = time.perf_counter() - started
        seen = [image for image in found if image.detections]
        poses = self.inner.estimate_all(seen) if seen else []
        return [
            replace(pose, time=pose.time + seconds[pose.scene_id, pose.image_id]) if pose.time >= 0 else pose
            for pose in poses
        ]

    def _with_detections(self, image: RgbdImage) -> RgbdImage:
        for stage in self._stages:
            image = replace(image, detections=tuple(stage(image)))
        return replace(image, detections=taken_by(self.inner, image.detections, self._names))


@dataclass(frozen=True)
class Composed:
    """What a name of ``ESTIMATORS`` stands for when it is a front end and an estimator, both by name."""

    front_end: str
    """Detectors and segmenters joined by +."""
    estimator: str
    """Estimates poses of what they find."""

    @property
    def inputs(self) -> str:
        """What it is made of."""
        return f"{self.front_end}, then {self.estimator}"

    def __call__(self) -> PoseEstimator:
        """Return the estimator with default settings."""
        return self.configured(PredictConfig())

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator.

        Raises:
            TrainingError: The front end or the estimator has no bundled weights.
            InputError: The estimator has no stages that ``config`` could choose, or cannot reject.
        """
        return WithFrontEnd(load_estimator(self.estimator, config), open_stages(self.front_end), config.objects)


@dataclass(frozen=True)
class Keypoints:
    """What ``detect-keypoints`` stands for: boxes of a detector, key points in them, perspective-n-point."""

    front_end: str
    network: str
    """Bundled network of key points."""

    @property
    def inputs(self) -> str:
        """What it is made of."""
        return f"{self.front_end}, then {self.network} and PnP"

    def __call__(self) -> PoseEstimator:
        """Return the estimator with default settings."""
        return self.configured(PredictConfig())

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator.

        Raises:
            TrainingError: The front end or the network has no bundled weights.
        """
        if self.network not in model_names():
            raise TrainingError(f"{self.network} has no bundled weights: train it, and predict with its run folder")
        return WithFrontEnd(KeypointEstimator(model_dir(self.network)), open_stages(self.front_end), config.objects)


DETECT_KEYPOINTS = Keypoints("detector-rgb", "keypoints-rgb")
DETECT_DENSEFUSION = Composed("detector-rgb+cluster", "densefusion")
DETECT_DEPTH = Composed("detector-depth+cluster", "densefusion-depth")
SEGMENT_DENSEFUSION = Composed("detector-depth+segmenter-depth", "densefusion")
SEGMENT_DENSEFUSION_EARLY = Composed("detector-depth+segmenter-depth", "densefusion-early")
SEGMENT_DENSEFUSION_MIDDLE_1 = Composed("detector-depth+segmenter-depth", "densefusion-middle-1")
SEGMENT_DENSEFUSION_MIDDLE_2 = Composed("detector-depth+segmenter-depth", "densefusion-middle-2")
SEGMENT_DENSEFUSION_DEPTH = Composed("detector-depth+segmenter-depth", "densefusion-depth")
SEGMENT_DENSEFUSION_POINTCLOUD = Composed("detector-depth+segmenter-depth", "densefusion-pointcloud")
SEGMENT_OBJECT_COORDINATES = Composed("detector-depth+segmenter-depth", "object-coordinates")
SEGMENT_RECTANGLE_FIT = Composed("detector-depth+segmenter-depth", "rectangle-fit")
SEGMENT_ICP_MULTISTART = Composed("detector-depth+segmenter-depth", "icp-multistart")
SEGMENT_FRONT_FIT = Composed("detector-depth+segmenter-depth", "front-fit")
