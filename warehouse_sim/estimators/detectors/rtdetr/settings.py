"""Settings of training an RT-DETR, and its names; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from warehouse_sim.estimators.detectors.settings import AnyDetectorConfig, TrainableOnImages
from warehouse_sim.ranges import Range, ranged

RtdetrSize = Literal["tiny", "r18", "r34", "r50"]


@dataclass(frozen=True)
@ranged
class RtdetrConfig(AnyDetectorConfig):
    """How an RT-DETR is trained."""

    learning_rate: Annotated[float, Range(0.000000001, 10)] = 2e-4
    """Peak learning rate, 0.000000001-10; falls along a cosine to a hundredth."""
    batch: Annotated[int, Range(1, 65_536)] = 16
    """Images a step, 1-65,536."""
    precision: Literal["32"] = "32"
    """Arithmetic of the network; in 16 bits its boxes would be off by pixels."""
    size: RtdetrSize = "r18"
    """Backbone and widths: r18, r34 and r50 are the published ones, tiny is for trials."""

    warmup_steps: ClassVar[int] = 500
    clip_norm: ClassVar[float] = 0.1
    """The authors'."""
    weight_decay: ClassVar[float] = 1e-4


@dataclass(frozen=True)
class TrainableRtdetr(TrainableOnImages):
    """An RT-DETR by what it reads."""

    settings: RtdetrConfig = RtdetrConfig()

    job: ClassVar[str] = "warehouse_sim.estimators.detectors.rtdetr.train:RtdetrJob"
    opens: ClassVar[str] = "warehouse_sim.estimators.detectors.rtdetr.network:TrainedRtdetr"
    extra: ClassVar[str] = "detectors"


RTDETR_RGB = TrainableRtdetr("rtdetr-rgb", "finds objects in colour images, by transformers", "RGB", reads=("rgb",))
RTDETR_DEPTH = TrainableRtdetr("rtdetr-depth", "finds objects in depth images, by transformers", "depth")
RTDETR_RGBD = TrainableRtdetr(
    "rtdetr-rgbd", "finds objects in colour and depth, by transformers", "RGB + depth", reads=("rgb", "depth")
)
