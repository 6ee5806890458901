"""What a detector, a segmenter and a pose estimator are, and what each must say and do."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from warehouse_sim.estimators.settings import DepthSource, PredictConfig

if TYPE_CHECKING:
    from warehouse_sim.dataset.objects import ObjectInfo
    from warehouse_sim.estimators.image import Detection, RgbdImage
    from warehouse_sim.geometry.mesh import TriangleMesh
    from warehouse_sim.learning.settings import LoopConfig, Progress
    from warehouse_sim.schema import PoseEstimate


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


class FrontEnd(ABC):
    """Finds objects in an image, or outlines those that were found; called with an image, it does so."""

    @abstractmethod
    def __call__(self, image: "RgbdImage", /) -> "Sequence[Detection]":
        """Return the detections that the next stage works on."""

    def leave_out_below(self, min_score: float) -> None:  # noqa: B027  what gives no scores has nothing to leave out
        """Leave out from now on what is found with a score below ``min_score`` (0-1)."""

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return True

    @property
    def reads_depth(self) -> bool:
        """Whether images need depth, or sweeps."""
        return True

    @property
    def reads_sweep(self) -> bool:
        """Whether it looks at sweeps as they are."""
        return False

    @property
    def depth_source(self) -> DepthSource:
        """Whose depth it was made for."""
        return "camera"

    @property
    def needs_detections(self) -> bool:
        """Whether it outlines what others found, and finds nothing by itself."""
        return False


class Detector(FrontEnd):
    """Finds objects in an image."""

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes that it distinguishes; empty where it does not say."""
        return ()

    @abstractmethod
    def detect(self, image: "RgbdImage") -> "Sequence[Detection]":
        """Return what is found, each with a mask or a box; the image's own detections are not looked at."""

    def __call__(self, image: "RgbdImage", /) -> "Sequence[Detection]":
        """Return what is found."""
        return self.detect(image)


class Segmenter(FrontEnd):
    """Outlines objects in an image: all that it finds, or where the image holds detections, those."""

    @abstractmethod
    def segment(self, image: "RgbdImage") -> "Sequence[Detection]":
        """Return detections with masks."""

    def __call__(self, image: "RgbdImage", /) -> "Sequence[Detection]":
        """Return detections with masks."""
        return self.segment(image)


class KnownObject(Protocol):
    """An object that an estimator knows."""

    @property
    def obj_id(self) -> int:
        """Number of the geometry in the dataset."""

    @property
    def name(self) -> str:
        """Name of the geometry."""

    @property
    def class_name(self) -> str:
        """Detection class of it; empty if unknown."""


class PoseEstimator(ABC):
    """Estimates the poses of what was detected in an image; each property has a default.

    What has another base class is adapted where it enters: ``own.estimator`` asks it for the same names.
    """

    @abstractmethod
    def estimate(self, image: "RgbdImage") -> "list[PoseEstimate]":
        """Return at most one pose for each detection, in their order; ``PoseEstimate.detection`` says whose it is."""

    def estimate_all(self, images: "Sequence[RgbdImage]") -> "list[PoseEstimate]":
        """Return what ``estimate`` returns for each image, one after the other; networks take them at once."""
        return [pose for image in images for pose in self.estimate(image)]

    def onboard(self, objects: "Mapping[int, ObjectInfo]") -> None:  # noqa: B027  networks need none
        """Take over what is to be known of a dataset's objects, by obj_id, before its first image (BOP: onboarding)."""

    @property
    def learns_objects(self) -> bool:
        """Whether it is to be shown the CAD models of a dataset."""
        return False

    @property
    def objects(self) -> Sequence[KnownObject] | None:
        """What it knows; None where it takes any object."""
        return None

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour, which else is not read."""
        return True

    @property
    def reads_depth(self) -> bool:
        """Whether images need depth, or sweeps."""
        return True

    @property
    def reads_sweep(self) -> bool:
        """Whether it looks at sweeps as they are."""
        return False

    @property
    def finds_objects(self) -> bool:
        """Whether its images need no detections."""
        return False

    @property
    def depth_source(self) -> DepthSource | None:
        """Whose depth it was made for; None where it does not matter."""
        return None

    @property
    def min_visible(self) -> LeastVisible:
        """Which of a dataset's targets it takes where the ground-truth masks are its detections."""
        return LeastVisible()

    @property
    def surfaces(self) -> "Mapping[int, TriangleMesh]":
        """CAD surfaces (m, object frame) by obj_id, as far as it keeps any."""
        return {}

    @property
    def stages_used(self) -> PredictConfig | None:
        """The settings with the stages that it chose where none were given; None where it has no stages."""
        return None


def _inners(name: str) -> Any:
    """Return a property that an estimator has from the one inside it."""
    return property(attrgetter(f"inner.{name}"))


class WrappedEstimator(PoseEstimator):
    """An estimator around another, which has what nobody says otherwise.

    Args:
        inner: The other.
    """

    learns_objects = _inners("learns_objects")
    objects = _inners("objects")
    reads_rgb = _inners("reads_rgb")
    reads_depth = _inners("reads_depth")
    reads_sweep = _inners("reads_sweep")
    finds_objects = _inners("finds_objects")
    depth_source = _inners("depth_source")
    min_visible = _inners("min_visible")
    surfaces = _inners("surfaces")
    stages_used = _inners("stages_used")

    def __init__(self, inner: PoseEstimator) -> None:
        self.inner = inner

    def onboard(self, objects: "Mapping[int, ObjectInfo]") -> None:
        """Show it the objects of a dataset."""
        self.inner.onboard(objects)


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

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator with these settings."""


class Composition(ABC):
    """What a name of ``ESTIMATORS`` stands for here when it is made of others; called, it has default settings."""

    front_end: str
    """Names of the detectors and segmenters that it is made of, joined by +; empty where nobody needs to know."""
    estimator: str
    """Name of the estimator behind them; empty where it has none."""

    @abstractmethod
    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator with these settings."""

    def __call__(self) -> PoseEstimator:
        """Return the estimator with default settings."""
        return self.configured(PredictConfig())


class Family(Protocol):
    """What a name of ``FAMILIES`` stands for: opens the run folders of one kind."""

    def __call__(self, run: Path, config: PredictConfig) -> PoseEstimator:
        """Return the trained estimator."""
