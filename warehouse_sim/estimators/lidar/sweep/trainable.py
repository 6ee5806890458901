"""What ``detector-sweep`` stands for in the registry of detectors: one that is trained; free of torch until used."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.lidar.sweep.settings import SweepDetectorConfig
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.resources import model_dir, model_names

if TYPE_CHECKING:
    from warehouse_sim.estimators.lidar.sweep.estimator import TrainedSweepDetector


@dataclass(frozen=True)
class TrainableSweepDetector:
    """A detector of sweeps; called without arguments, it is opened with its bundled weights."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    settings: SweepDetectorConfig = SweepDetectorConfig()  # noqa: RUF009  frozen
    """How it is trained by default; says the type of its settings, too."""

    def __call__(self) -> "TrainedSweepDetector":
        """Open the bundled weights.

        Raises:
            TrainingError: There are none.
        """
        from warehouse_sim.estimators.lidar.sweep.estimator import TrainedSweepDetector

        return TrainedSweepDetector(self.bundled())

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
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be a ``SweepDetectorConfig``."""
        from warehouse_sim.estimators.detectors.job import image_cache, train_detector
        from warehouse_sim.estimators.lidar.sweep.train import SweepJob

        if not isinstance(config, SweepDetectorConfig):
            raise TrainingError(f"{self.name} is trained with a SweepDetectorConfig, found a {type(config).__name__}")
        job = SweepJob(self.name, (), tuple(data), run, config, image_cache(cache))
        return train_detector(job, resume, progress, init)


DETECTOR_SWEEP = TrainableSweepDetector("detector-sweep", "finds objects in whole LiDAR sweeps", "LiDAR sweep")
