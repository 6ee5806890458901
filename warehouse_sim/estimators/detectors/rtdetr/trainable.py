"""What a name of the registry of detectors stands for here: an RT-DETR; free of torch until it is used."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.rtdetr.settings import RtdetrConfig
from warehouse_sim.estimators.detectors.trainable import AnyTrainableDetector
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.optional import require_extra

if TYPE_CHECKING:
    from warehouse_sim.estimators.detectors.rtdetr.estimator import TrainedRtdetr


@dataclass(frozen=True)
class TrainableRtdetr(AnyTrainableDetector):
    """An RT-DETR by what it reads; called without arguments, it is opened with its bundled weights."""

    settings: RtdetrConfig = RtdetrConfig()  # noqa: RUF009  frozen
    """How it is trained by default; says the type of its settings, too."""

    def __call__(self) -> "TrainedRtdetr":
        """Open the bundled weights.

        Raises:
            TrainingError: There are none.
            MissingPackageError: The library is not installed.
        """
        from warehouse_sim.estimators.detectors.rtdetr.estimator import TrainedRtdetr

        return TrainedRtdetr(self.bundled())

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
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be an ``RtdetrConfig``."""
        require_extra("detectors", f"to train {self.name}")
        from warehouse_sim.estimators.detectors.job import image_cache, train_detector
        from warehouse_sim.estimators.detectors.rtdetr.train import RtdetrJob

        if not isinstance(config, RtdetrConfig):
            raise TrainingError(f"{self.name} is trained with an RtdetrConfig, found a {type(config).__name__}")
        job = RtdetrJob(self.name, self.reads, tuple(data), run, config, image_cache(cache))
        return train_detector(job, resume, progress, init)


RTDETR_RGB = TrainableRtdetr("rtdetr-rgb", "finds objects in colour images, by transformers", "RGB", ("rgb",))
RTDETR_DEPTH = TrainableRtdetr("rtdetr-depth", "finds objects in depth images, by transformers", "depth", ("depth",))
RTDETR_RGBD = TrainableRtdetr(
    "rtdetr-rgbd", "finds objects in colour and depth, by transformers", "RGB + depth", ("rgb", "depth")
)
