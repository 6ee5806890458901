"""Settings of training a segmenter, and its names; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.learning.settings import StreamedConfig
from warehouse_sim.learning.trainable import TrainableNetwork
from warehouse_sim.ranges import Fraction, Range, ranged


@dataclass(frozen=True)
@ranged
class BoxCropConfig:
    """How boxes are cut out."""

    reads: Reads = ("depth",)
    """Inputs, in the order of their channels."""
    crop_wh: Annotated[tuple[int, int], Range(16, 1024, "px")] = (128, 64)
    """Size of a crop, 16-1,024, multiples of 16; boxes are stretched to it, whatever their shape."""
    margin: Fraction = 0.3
    """What is seen on each side of a box, as a fraction of its size, 0-1."""
    spare: Annotated[float, Range(1, 4)] = 1.8
    """Stored crops are larger by this factor, so that training can move boxes, 1-4."""

    def __post_init__(self) -> None:
        if any(edge % 16 for edge in self.crop_wh):
            raise ValueError(f"crop_wh must be multiples of 16, found {self.crop_wh}")

    @property
    def stored_wh(self) -> tuple[int, int]:
        """Size of stored crops (px)."""
        return round(self.crop_wh[0] * self.spare), round(self.crop_wh[1] * self.spare)

    @property
    def stored_margin(self) -> float:
        """What stored crops show on each side of a box, as a fraction of its size."""
        return ((1.0 + 2.0 * self.margin) * self.spare - 1.0) / 2.0


@dataclass(frozen=True)
@ranged
class SegmenterConfig(StreamedConfig):
    """How a segmenter is trained."""

    learning_rate: Annotated[float, Range(0.000000001, 10)] = 2e-3
    """Peak learning rate, 0.000000001-10; falls along a cosine to a hundredth."""
    batch: Annotated[int, Range(1, 65_536)] = 32
    """Boxes a step, 1-65,536."""
    precision: Literal["auto", "32", "bf16"] = "32"
    """Arithmetic of the network; depths of centimetres at metres need 32 bits."""
    width: Annotated[int, Range(4, 512)] = 16
    """Filters of the first stage, 4-512; later ones have up to four times as many."""
    classes: tuple[str, ...] = ()
    """Only objects of these classes, or of these names; all targets by default."""
    kinds: tuple[str, ...] = ()
    """Names of objects that it distinguishes in boxes, those of the catalog that are alike; none by default."""
    visible: Fraction = 0.1
    """Least visible fraction of an object, 0-1."""
    height_px: Annotated[float, Range(0, 10_000, "px")] = 6.0
    """Least height of its visible part in the image, 0-10,000."""
    workers: Annotated[int, Range(1, 1024)] = 2
    """Threads that decode images and compose samples, 1-1,024; 1 does both in the training's own thread."""


@dataclass(frozen=True)
class TrainableSegmenter(TrainableNetwork):
    """A segmenter by what it reads."""

    reads: Reads = ("depth",)
    keypoints: bool = False
    """Whether it finds key points of pallets' faces, too."""
    settings: SegmenterConfig = SegmenterConfig()

    job: ClassVar[str] = "warehouse_sim.estimators.segmenters.segnet.train:SegmenterJob"
    opens: ClassVar[str] = "warehouse_sim.estimators.segmenters.segnet.estimator:TrainedSegmenter"


_MASKS, _FACES = "segments the object in a box, in", "segments pallets and finds the corners and pockets of their faces"
SEGMENTER_RGB = TrainableSegmenter("segmenter-rgb", f"{_MASKS} colour", "RGB", reads=("rgb",))
SEGMENTER_DEPTH = TrainableSegmenter("segmenter-depth", f"{_MASKS} depth", "depth")
SEGMENTER_RGBD = TrainableSegmenter(
    "segmenter-rgbd", f"{_MASKS} colour and depth", "RGB + depth", reads=("rgb", "depth")
)
KEYPOINTS_RGB = TrainableSegmenter("keypoints-rgb", _FACES, "RGB", reads=("rgb",), keypoints=True)
KEYPOINTS_RGBD = TrainableSegmenter("keypoints-rgbd", _FACES, "RGB + depth", reads=("rgb", "depth"), keypoints=True)
