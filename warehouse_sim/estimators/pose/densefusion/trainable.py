"""What a name of the registry stands for in this family: a method that is trained and calibrated."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.methods import Method
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.settings import LoopConfig

if TYPE_CHECKING:
    from warehouse_sim.estimators.pose.densefusion.training.streamed_crops import OpenStream


@dataclass(frozen=True)
class TrainableMethod(Method):
    """A method with its training; what that needs is imported on use, since a list of names needs none of it."""

    takes_streams: ClassVar[bool] = True
    """Whether ``train`` takes observations that no file holds."""

    def train(
        self,
        data: Sequence[Path],
        run: Path,
        config: LoopConfig,
        resume: bool = False,
        progress: Progress | None = None,
        init: str | Path | None = None,
        cache: Path | None = None,
        open_stream: "OpenStream | None" = None,
    ) -> Path:
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be a ``TrainConfig``."""
        from warehouse_sim.estimators.pose.densefusion.training.train import train_method

        if not isinstance(config, TrainConfig):
            raise TrainingError(f"{self.name} is trained with a TrainConfig, found a {type(config).__name__}")
        return train_method(self, data, run, config, resume, progress, init, cache, open_stream)

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Fit how confidence predicts the error, and say so when val shows too little for it."""
        from warehouse_sim.estimators.pose.densefusion.calibrate import LEAST_SAMPLES, calibrate

        if calibrate(run, data, progress=progress).curves:
            return ""
        return f"val shows too few objects (fewer than {LEAST_SAMPLES}) to tell errors from confidence"
