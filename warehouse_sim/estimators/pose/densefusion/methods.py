"""What can be trained by name: each method fixes the inputs of a network and its widths at each size."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, get_args

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.settings import Size, TrainConfig
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.settings import LoopConfig

if TYPE_CHECKING:
    from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusionConfig


class NetworkAtSize(Protocol):
    """Gives a method's network at a size."""

    def __call__(self, size: Size, faithful: bool = False) -> "DenseFusionConfig":
        """Return the network's configuration; ``faithful`` keeps the original's quirks."""


@dataclass(frozen=True)
class Method:
    """One estimator that learns: its name, what it reads, and its network at each size."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    network: NetworkAtSize
    """The network's configuration at a size."""

    def parameters(self, classes: int = 1) -> dict[str, int]:
        """Return the number of weights by size."""
        import torch

        from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion

        # On this device tensors have shapes and no memory.
        with torch.device("meta"):
            networks = {size: DenseFusion(self.network(size), classes) for size in get_args(Size)}
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
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be a ``TrainConfig``."""
        from warehouse_sim.estimators.pose.densefusion.training.train import train_method

        if not isinstance(config, TrainConfig):
            raise TrainingError(f"{self.name} is trained with a TrainConfig, found a {type(config).__name__}")
        return train_method(self, data, run, config, resume, progress, init, cache)

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Fit how confidence tells the error, and tell people when val shows too little for it."""
        from warehouse_sim.estimators.pose.densefusion.calibrate import LEAST_SAMPLES, calibrate

        if calibrate(run, data, progress=progress).curves:
            return ""
        return f"val shows too few objects (fewer than {LEAST_SAMPLES}) to tell errors from confidence"
