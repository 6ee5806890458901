"""Settings of training a detector, and their names; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.images.settings import DepthSource, ImageAugmentConfig, Reads
from warehouse_sim.learning.settings import LoopConfig, StreamedConfig
from warehouse_sim.learning.trainable import TrainableNetwork
from warehouse_sim.ranges import Fraction, Range, ranged

Labels = Literal["class", "object"]
DetectorSize = Literal["pico", "nano", "small"]
Backbone = Literal["csp", "efficientnet_lite0"]


@dataclass(frozen=True)
@ranged
class WantedConfig:
    """Which targets a detector is to find; it is neither taught nor scored on others."""

    visible: Fraction = 0.1
    """Least visible fraction, 0-1."""
    height_px: Annotated[float, Range(0, 10_000, "px")] = 8.0
    """Least height of the visible part in the image itself, 0-10,000."""


@dataclass(frozen=True)
@ranged
class BoxTrainingConfig(LoopConfig):
    """How any network that gives boxes is trained, whatever it looks at."""

    batch: Annotated[int, Range(1, 65_536)] = 8
    """Images a step, 1-65,536."""
    learning_rate: Annotated[float, Range(0.000000001, 10)] = 2e-3
    """Peak learning rate, 0.000000001-10; falls along a cosine to a hundredth."""
    precision: Literal["auto", "32", "bf16"] = "32"
    """Arithmetic of the network; layers as narrow as these are no faster in 16 bits on most CPUs."""
    size: DetectorSize = "nano"
    """Widths of the network: nano and small are those of the original, pico is half of nano."""
    labels: Labels = "class"
    """What is distinguished: classes (pallet, carton), or objects (epal1, epal2)."""
    classes: tuple[str, ...] = ()
    """Only these classes, or objects; all targets by default."""
    workers: Annotated[int, Range(1, 1024)] = 2
    """Threads that decode images and compose samples, 1-1,024; 1 does both in the training's own thread."""

    clip_norm: ClassVar[float] = 10.0
    weight_decay: ClassVar[float] = 5e-4

    def is_wanted(self, labels: Float[np.ndarray, "k 8"]) -> Bool[np.ndarray, " k"]:
        """Return which labels are to be found; of others nothing is taught."""
        raise NotImplementedError


@dataclass(frozen=True)
@ranged
class DetectorConfig(BoxTrainingConfig, StreamedConfig):
    """How a network that finds objects in images is trained."""

    input_wh: Annotated[tuple[int, int], Range(32, 8192, "px")] = (640, 192)
    """Size that images are scaled to, 32-8,192; images of another shape keep theirs and get the same area."""
    depth_source: DepthSource = "camera"
    """Where depth comes from: the depth camera, or sweeps of the main LiDAR, projected and upsampled."""
    backbone: Backbone = "csp"
    """What sees the image: layers that are trained with all others, or features of photographs that are not
    (EfficientNet-Lite0, trained on ImageNet), which read colours alone and come with the weights of ``--init``."""
    wanted: WantedConfig = field(default_factory=WantedConfig)
    """Which targets are to be found."""
    augment: ImageAugmentConfig = field(default_factory=ImageAugmentConfig)
    """How images are disturbed."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.fed_by and self.depth_source == "lidar":
            raise ValueError("a stream has no sweeps: leave out stream.recipe, or take depth_source camera")

    def is_wanted(self, labels: Float[np.ndarray, "k 8"]) -> Bool[np.ndarray, " k"]:
        """Return which labels are to be found; of others nothing is taught."""
        wanted: Bool[np.ndarray, " k"] = (labels[:, 5] >= self.wanted.visible) & (labels[:, 6] >= self.wanted.height_px)
        return wanted

    def defaults(self) -> Self:
        """Return the settings of whoever names none, to go on with a run; the name says whose depth is seen."""
        return type(self)(depth_source=self.depth_source)


@dataclass(frozen=True)
class TrainableDetector(TrainableNetwork):
    """A detector by what it reads of images."""

    reads: Reads = ("depth",)
    settings: DetectorConfig = DetectorConfig()

    job: ClassVar[str] = "warehouse_sim.estimators.detectors.task:BoxJob"
    opens: ClassVar[str] = "warehouse_sim.estimators.detectors.estimator:TrainedDetector"


DETECTOR_RGB = TrainableDetector("detector-rgb", "finds objects in colour images", "RGB", reads=("rgb",))
DETECTOR_DEPTH = TrainableDetector("detector-depth", "finds objects in depth images", "depth")
DETECTOR_RGBD = TrainableDetector(
    "detector-rgbd", "finds objects in colour and depth", "RGB + depth", reads=("rgb", "depth")
)
DETECTOR_LIDAR = TrainableDetector(
    "detector-lidar",
    "finds objects in depth images made of LiDAR sweeps",
    "LiDAR",
    settings=DetectorConfig(depth_source="lidar"),
)
