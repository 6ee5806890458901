"""The methods of the family by name: their inputs, their widths at each size, how they are trained and calibrated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Literal

from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusionConfig
from warehouse_sim.estimators.pose.densefusion.networks.heads import HeadConfig
from warehouse_sim.estimators.pose.densefusion.networks.image import AttentionConfig, ImageConfig, Reading
from warehouse_sim.estimators.pose.densefusion.networks.points import PointConfig
from warehouse_sim.estimators.pose.densefusion.networks.refiner import RefinerConfig
from warehouse_sim.estimators.pose.densefusion.settings import Size, TrainConfig
from warehouse_sim.learning.settings import Progress
from warehouse_sim.learning.trainable import TrainableNetwork

_SIZES: dict[Size, tuple[PointConfig, HeadConfig, RefinerConfig, ImageConfig]] = {
    "nano": (
        PointConfig(count=256, local=(64, 128), pooled=(256, 512), pooling="average+max"),
        HeadConfig(widths=(256, 128), shared=True, training_points=64),
        RefinerConfig(local=(32, 64), pooled=(128, 256), widths=(128, 64)),
        ImageConfig(kind="unet", side_px=48, width=24),
    ),
    "small": (
        PointConfig(count=256, local=(64, 128), pooled=(512, 1024), pooling="average+max"),
        HeadConfig(widths=(320, 128, 64), shared=False, training_points=128),
        RefinerConfig(local=(64, 128), pooled=(256, 512), widths=(256, 128)),
        ImageConfig(kind="psp-resnet18", side_px=64, width=32),
    ),
    "full": (
        PointConfig(count=500, local=(64, 128), pooled=(512, 1024), pooling="average"),
        HeadConfig(widths=(640, 256, 128), shared=False),
        RefinerConfig(local=(64, 128), pooled=(512, 1024), widths=(512, 128)),
        ImageConfig(kind="psp-resnet18", side_px=80, width=64),
    ),
}
"""The parts of each network, each image branch being as the last."""


@dataclass(frozen=True)
class Method(TrainableNetwork):
    """A name, what it reads, and its network at each size."""

    settings: TrainConfig = TrainConfig()  # noqa: RUF009  frozen
    images: tuple[tuple[Reading, ...], ...] = ()
    """What each image branch reads."""
    attention: tuple[AttentionConfig, AttentionConfig] | None = None
    """What fuses the images at the size nano, and at others."""
    predicts: Literal["poses", "coordinates"] = "poses"
    """What its heads give."""

    job: ClassVar[str] = "warehouse_sim.estimators.pose.densefusion.training.train:PoseJob"

    def network(self, size: Size, paper: bool = False) -> DenseFusionConfig:
        """Return the network's configuration; ``paper`` keeps the quirks of Wang et al.'s code, for parity."""
        points, heads, refiner, image = _SIZES[size]
        images = tuple(replace(image, reads=reads, paper=paper) for reads in self.images)
        if paper:
            points = replace(points, pooling="average")
            heads = replace(heads, shared=False, class_bias=False, training_points=None)
            refiner = replace(refiner, paper=True)
        if self.predicts == "coordinates":
            # One trunk at any size: coordinates and their scale are one prediction.
            heads = replace(heads, shared=True, predicts="coordinates")
        fusion = self.attention[size != "nano"] if self.attention else None
        return DenseFusionConfig(points, heads, refiner, images, fusion)

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Fit how confidence predicts the error, and say so when val shows too little for it."""
        from warehouse_sim.estimators.pose.densefusion.calibrate import LEAST_SAMPLES, calibrate

        if calibrate(run, data, progress=progress).curves:
            return ""
        return f"val shows too few objects (fewer than {LEAST_SAMPLES}) to tell errors from confidence"


_TWO_CROPS = "RGB crop + depth crop + point cloud"
DENSEFUSION = Method(
    "densefusion", "pixel-wise fusion of colour and cloud", "RGB crop + point cloud", images=(("rgb",),)
)
DENSEFUSION_EARLY = Method(
    "densefusion-early",
    "colour and depth joined before the first layer",
    "RGB + depth crop + point cloud",
    images=(("rgb", "depth"),),
)
# The two middle fusions differ in the embedding of the attention alone.
DENSEFUSION_MIDDLE_1 = Method(
    "densefusion-middle-1",
    "colour and depth fused by attention over the points, small embedding",
    _TWO_CROPS,
    images=(("rgb",), ("depth",)),
    attention=(AttentionConfig(32, heads=4), AttentionConfig(64, heads=4)),
)
DENSEFUSION_MIDDLE_2 = Method(
    "densefusion-middle-2",
    "colour and depth fused by attention over the points, large embedding",
    _TWO_CROPS,
    images=(("rgb",), ("depth",)),
    attention=(AttentionConfig(128, heads=4), AttentionConfig(256, heads=8)),
)
DENSEFUSION_DEPTH = Method(
    "densefusion-depth", "the depth image in place of colour", "depth crop + point cloud", images=(("depth",),)
)
DENSEFUSION_POINTCLOUD = Method("densefusion-pointcloud", "the cloud alone", "point cloud")
OBJECT_COORDINATES = Method(
    "object-coordinates",
    "object coordinates at each point and a weighted least-squares pose",
    "RGB crop + point cloud",
    images=(("rgb",),),
    predicts="coordinates",
)
