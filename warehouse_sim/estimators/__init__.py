"""From images to poses in files: what a detector, a segmenter and a pose estimator are, and where they are registered.

A name of ``ESTIMATORS``, ``DETECTORS`` or ``SEGMENTERS`` stands for something that is called without arguments and
returns one, or, among the estimators, for something that first is trained.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from warehouse_sim.registry import Registry

if TYPE_CHECKING:
    from warehouse_sim.dataset.objects import ObjectInfo
    from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
    from warehouse_sim.estimators.settings import PredictConfig
    from warehouse_sim.learning.progress import Progress
    from warehouse_sim.learning.settings import LoopConfig
    from warehouse_sim.schema import PoseEstimate


class Detector(Protocol):
    """Finds objects in an image."""

    def detect(self, image: "RgbdImage") -> "Sequence[Detection]":
        """Return what is found, each with a mask or a box; the image's own detections are not looked at."""


class Segmenter(Protocol):
    """Outlines objects in an image: all that it finds, or where the image holds detections, those."""

    def segment(self, image: "RgbdImage") -> "Sequence[Detection]":
        """Return detections with masks."""


class KnownObject(Protocol):
    """An object that an estimator knows."""

    @property
    def obj_id(self) -> int:
        """Number of the geometry in the dataset."""

    @property
    def name(self) -> str:
        """Name of the geometry."""


class PoseEstimator(Protocol):
    """Estimates the poses of what was detected in an image.

    Two more attributes are requested where there are such: ``reads_rgb``, False where colour is not needed, which then
    is not read, and ``least_visible``, which of a dataset's targets it takes where the ground-truth masks are its
    detections.
    """

    @property
    def objects(self) -> Sequence[KnownObject] | None:
        """What it knows; None where it takes any object."""

    def estimate(self, image: "RgbdImage") -> "list[PoseEstimate]":
        """Return at most one pose for each detection, in their order; ``PoseEstimate.detection`` says whose it is."""


@runtime_checkable
class BatchedPoseEstimator(PoseEstimator, Protocol):
    """Takes several images at once, which is faster for a network."""

    def estimate_all(self, images: "Sequence[RgbdImage]") -> "list[PoseEstimate]":
        """Return what ``estimate`` returns for each image, one after the other."""


@runtime_checkable
class Onboarding(Protocol):
    """An estimator that is shown the CAD models of a dataset before its first image (BOP: onboarding)."""

    def onboard(self, objects: "Mapping[int, ObjectInfo]") -> None:
        """Take over what is to be known of the objects, by obj_id."""


@runtime_checkable
class Trainable(Protocol):
    """What a name of ``ESTIMATORS``, ``DETECTORS`` or ``SEGMENTERS`` stands for when it must be trained first.

    An attribute ``settings`` may hold the settings that it is trained with by default, of the type that it takes.
    """

    def train(
        self,
        data: Sequence[Path],
        run: Path,
        config: "LoopConfig",
        resume: bool = False,
        progress: "Progress | None" = None,
        init: str | Path | None = None,
        cache: Path | None = None,
    ) -> Path:
        """Train on the train splits of ``data`` and return the run folder, whose ``config.yaml`` says its ``kind``."""

    def calibrate(self, run: Path, data: Sequence[Path], progress: "Progress | None" = None) -> str:
        """Fit on the val splits how scores predict errors, and return what people should know of it; mostly nothing."""


@runtime_checkable
class Configurable(Protocol):
    """What a name of ``ESTIMATORS`` may stand for when its estimator takes the settings of prediction."""

    def configured(self, config: "PredictConfig") -> PoseEstimator:
        """Return the estimator with these settings."""


class Family(Protocol):
    """What a name of ``FAMILIES`` stands for: opens the run folders of one kind."""

    def __call__(self, run: Path, config: "PredictConfig") -> PoseEstimator:
        """Return the trained estimator."""


ESTIMATORS = Registry("estimator")
for _name in (
    "densefusion",
    "densefusion-early",
    "densefusion-middle-1",
    "densefusion-middle-2",
    "densefusion-depth",
    "densefusion-pointcloud",
    "object-coordinates",
):
    _constant = _name.upper().replace("-", "_")
    ESTIMATORS.add(_name, f"warehouse_sim.estimators.pose.densefusion.networks.family:{_constant}")
ESTIMATORS.add("rectangle-fit", "warehouse_sim.estimators.pose.fitting.fit:rectangle_fit")
ESTIMATORS.add("icp-multistart", "warehouse_sim.estimators.pose.fitting.fit:icp_multistart")
ESTIMATORS.add("front-fit", "warehouse_sim.estimators.pose.faces.estimator:front_fit")
for _name in (
    "detect-densefusion",
    "detect-depth",
    "detect-keypoints",
    "segment-densefusion",
    "segment-densefusion-early",
    "segment-densefusion-middle-1",
    "segment-densefusion-middle-2",
    "segment-densefusion-depth",
    "segment-densefusion-pointcloud",
    "segment-object-coordinates",
    "segment-rectangle-fit",
    "segment-icp-multistart",
    "segment-front-fit",
):
    ESTIMATORS.add(_name, f"warehouse_sim.estimators.composed:{_name.upper().replace('-', '_')}")
ESTIMATORS.add("detect-pointcloud", "warehouse_sim.estimators.lidar.pointcloud:DETECT_POINTCLOUD")
ESTIMATORS.add("lidar-direct", "warehouse_sim.estimators.sweep.direct:LIDAR_DIRECT")
DETECTORS = Registry("detector")
for _name in ("detector-rgb", "detector-depth", "detector-rgbd", "detector-lidar"):
    _constant = _name.upper().replace("-", "_")
    DETECTORS.add(_name, f"warehouse_sim.estimators.detection.trainable:{_constant}")
for _name in ("rtdetr-rgb", "rtdetr-depth", "rtdetr-rgbd"):
    DETECTORS.add(_name, f"warehouse_sim.estimators.rtdetr.trainable:{_name.upper().replace('-', '_')}")
DETECTORS.add("detector-sweep", "warehouse_sim.estimators.sweep.trainable:DETECTOR_SWEEP")
SEGMENTERS = Registry("segmenter")
for _name in ("segmenter-rgb", "segmenter-depth", "segmenter-rgbd", "keypoints-rgb", "keypoints-rgbd"):
    _constant = _name.upper().replace("-", "_")
    SEGMENTERS.add(_name, f"warehouse_sim.estimators.segmentation.trainable:{_constant}")
SEGMENTERS.add("cluster", "warehouse_sim.estimators.lidar.segment:BoxClusters")
FAMILIES = Registry("kind of run folder", group="warehouse_sim.estimator_families")
FAMILIES.add("densefusion", "warehouse_sim.estimators.pose.densefusion.estimator:Estimator")
FRONT_ENDS = Registry("kind of run folder that finds objects", group="warehouse_sim.front_end_families")
FRONT_ENDS.add("detector", "warehouse_sim.estimators.detection.estimator:TrainedDetector")
FRONT_ENDS.add("sweep-detector", "warehouse_sim.estimators.sweep.estimator:TrainedSweepDetector")
FRONT_ENDS.add("rtdetr", "warehouse_sim.estimators.rtdetr.estimator:TrainedRtdetr")
FRONT_ENDS.add("segmenter", "warehouse_sim.estimators.segmentation.estimator:TrainedSegmenter")


def is_trainable(registered: Any) -> bool:
    """Return whether what a name stands for must be trained first."""
    return isinstance(registered, Trainable) and not isinstance(registered, type)


def trained_names() -> list[str]:
    """Return the names of ``ESTIMATORS`` that must be trained first; each is imported."""
    return [name for name in ESTIMATORS.names() if is_trainable(ESTIMATORS.get(name))]
