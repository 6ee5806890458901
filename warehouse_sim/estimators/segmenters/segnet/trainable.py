"""What a name of the registry of segmenters stands for here: one that is trained; free of torch until it is used."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.resources import model_dir, model_names

if TYPE_CHECKING:
    from warehouse_sim.estimators.segmenters.segnet.estimator import TrainedSegmenter


@dataclass(frozen=True)
class TrainableSegmenter:
    """A segmenter by what it reads; called without arguments, it is opened with its bundled weights."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    reads: Reads
    keypoints: bool = False
    """Whether it finds key points of pallets' faces, too."""
    settings: SegmenterConfig = SegmenterConfig()  # noqa: RUF009  frozen
    """How it is trained by default; says the type of its settings, too."""

    def __call__(self) -> "TrainedSegmenter":
        """Open the bundled weights.

        Raises:
            TrainingError: There are none.
        """
        from warehouse_sim.estimators.segmenters.segnet.estimator import TrainedSegmenter

        if self.name not in model_names():
            raise TrainingError(f"{self.name} has no bundled weights: train it first, and give the run folder instead")
        return TrainedSegmenter(model_dir(self.name))

    def parameters(self, classes: int = 1) -> dict[str, int]:
        """Return the number of weights at the width that is the default."""
        from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS
        from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork, SegmenterNetworkConfig
        from warehouse_sim.learning.compute import shapes_only

        with shapes_only():
            points = POINTS if self.keypoints else 0
            network = SegmenterNetwork(SegmenterNetworkConfig(self.reads, self.settings.width, points))
        return {"nano": sum(item.numel() for item in network.parameters())}

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
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be a ``SegmenterConfig``."""
        from warehouse_sim.estimators.segmenters.segnet.train import train_segmenter

        if not isinstance(config, SegmenterConfig):
            raise TrainingError(f"{self.name} is trained with a SegmenterConfig, found a {type(config).__name__}")
        return train_segmenter(self.name, self.reads, self.keypoints, data, run, config, resume, progress, init, cache)

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Do nothing: probabilities of pixels are what training made them."""
        return ""


SEGMENTER_RGB = TrainableSegmenter("segmenter-rgb", "outlines what boxes are about in colour", "RGB", ("rgb",))
SEGMENTER_DEPTH = TrainableSegmenter("segmenter-depth", "outlines what boxes are about in depth", "depth", ("depth",))
SEGMENTER_RGBD = TrainableSegmenter(
    "segmenter-rgbd", "outlines what boxes are about in colour and depth", "RGB + depth", ("rgb", "depth")
)
KEYPOINTS_RGB = TrainableSegmenter(
    "keypoints-rgb", "outlines pallets and finds the corners and pockets of their faces", "RGB", ("rgb",), True
)
KEYPOINTS_RGBD = TrainableSegmenter(
    "keypoints-rgbd",
    "outlines pallets and finds the corners and pockets of their faces",
    "RGB + depth",
    ("rgb", "depth"),
    True,
)
