"""What a name of the registry of detectors stands for here: one that is trained; free of torch until it is used."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.settings import AnyDetectorConfig, DetectorConfig
from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.resources import model_dir, model_names

if TYPE_CHECKING:
    from warehouse_sim.estimators.detectors.estimator import TrainedDetector


@dataclass(frozen=True)
class AnyTrainableDetector:
    """A detector of any network by what it reads."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    reads: Reads
    settings: AnyDetectorConfig
    """How it is trained by default; says the type of its settings, too."""

    def bundled(self) -> Path:
        """Return the folder of the bundled weights.

        Raises:
            TrainingError: There are none.
        """
        if self.name not in model_names():
            raise TrainingError(f"{self.name} has no bundled weights: train it first, and give the run folder instead")
        return model_dir(self.name)

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Do nothing: scores of detections rank, and nothing more is requested of them."""
        return ""


@dataclass(frozen=True)
class TrainableDetector(AnyTrainableDetector):
    """A detector of this package; called without arguments, it is opened with its bundled weights."""

    settings: DetectorConfig = DetectorConfig()  # noqa: RUF009  frozen
    """How it is trained by default; says the type of its settings, too."""

    def __call__(self) -> "TrainedDetector":
        """Open the bundled weights.

        Raises:
            TrainingError: There are none.
        """
        from warehouse_sim.estimators.detectors.estimator import TrainedDetector

        return TrainedDetector(self.bundled())

    def parameters(self, classes: int = 1) -> dict[str, int]:
        """Return the number of weights by size."""
        from warehouse_sim.estimators.detectors.preparation import DEPTH, WIDTHS
        from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorNetworkConfig
        from warehouse_sim.estimators.images.settings import ImageConfig
        from warehouse_sim.learning.compute import shapes_only

        with shapes_only():
            networks = {
                size: DetectorNetwork(DetectorNetworkConfig(width, DEPTH, classes), ImageConfig(self.reads))
                for size, width in WIDTHS.items()
            }
        return {size: sum(item.numel() for item in network.parameters()) for size, network in networks.items()}

    def train(
        self,
        data: Sequence[Path],
        run: Path,
        config: LoopConfig,
        resume: bool = False,
        progress: Progress | None = None,
        init: str | Path | None = None,
        cache: Path | None = None,
    ) -> Path:
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be a ``DetectorConfig``."""
        from warehouse_sim.estimators.detectors.job import DetectorJob, image_cache, train_detector

        if not isinstance(config, DetectorConfig):
            raise TrainingError(f"{self.name} is trained with a DetectorConfig, found a {type(config).__name__}")
        job = DetectorJob(self.name, self.reads, tuple(data), run, config, image_cache(cache))
        return train_detector(job, resume, progress, init)


DETECTOR_RGB = TrainableDetector("detector-rgb", "finds objects in colour images", "RGB", ("rgb",))
DETECTOR_DEPTH = TrainableDetector("detector-depth", "finds objects in depth images", "depth", ("depth",))
DETECTOR_RGBD = TrainableDetector("detector-rgbd", "finds objects in colour and depth", "RGB + depth", ("rgb", "depth"))
DETECTOR_LIDAR = TrainableDetector(
    "detector-lidar",
    "finds objects in depth images made of LiDAR sweeps",
    "LiDAR",
    ("depth",),
    DetectorConfig(depth_source="lidar"),
)
