"""What a detector, a segmenter and a pose estimator are, and what each must say and do."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, runtime_checkable

if TYPE_CHECKING:
    from warehouse_sim.dataset.objects import ObjectInfo
    from warehouse_sim.estimators.image import Detection, RgbdImage
    from warehouse_sim.estimators.settings import PredictConfig
    from warehouse_sim.learning.settings import LoopConfig, Progress
    from warehouse_sim.schema import PoseEstimate


DepthSource = Literal["camera", "lidar", "lidar-sparse"]
"""Whose depth is seen: the camera's own, the main LiDAR's filled up, or only where it has points."""


class _Target(Protocol):
    @property
    def visible_fraction(self) -> float: ...
    @property
    def pixels_visible(self) -> int: ...


class LeastVisible(NamedTuple):
    """What must be seen of a target at least."""

    fraction: float = 0.1
    """Visible fraction of it, 0-1."""
    pixels: int = 32
    """Visible pixels."""

    def takes(self, target: _Target) -> bool:
        """Return whether so much is seen of a target."""
        return target.visible_fraction >= self.fraction and target.pixels_visible >= self.pixels


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
