"""The methods of the family by name: their inputs, their widths at each size, how they are trained and calibrated."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import ClassVar, Protocol, get_args

from warehouse_sim.estimators.pose.densefusion.networks.attention import AttentionConfig
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, DenseFusionConfig
from warehouse_sim.estimators.pose.densefusion.networks.heads import HeadConfig
from warehouse_sim.estimators.pose.densefusion.networks.image import ImageConfig, Reading
from warehouse_sim.estimators.pose.densefusion.networks.points import PointConfig
from warehouse_sim.estimators.pose.densefusion.networks.refiner import RefinerConfig
from warehouse_sim.estimators.pose.densefusion.settings import Size, TrainConfig
from warehouse_sim.learning.compute import count_weights
from warehouse_sim.learning.settings import Progress
from warehouse_sim.learning.trainable import TrainableNetwork


class NetworkAtSize(Protocol):
    """Gives a method's network at a size."""

    def __call__(self, size: Size, paper: bool = False) -> DenseFusionConfig:
        """Return the network's configuration; ``paper`` keeps the original's quirks."""


@dataclass(frozen=True)
class Method(TrainableNetwork):
    """A name, what it reads, and its network at each size."""

    settings: TrainConfig = TrainConfig()  # noqa: RUF009  frozen
    network: NetworkAtSize = field(kw_only=True)
    """The network's configuration at a size."""

    job: ClassVar[str] = "warehouse_sim.estimators.pose.densefusion.training.train:PoseJob"

    def parameters(self, classes: int = 1) -> dict[str, int]:
        """Return the number of weights by size."""
        return count_weights({size: partial(DenseFusion, self.network(size), classes) for size in get_args(Size)})

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Fit how confidence predicts the error, and say so when val shows too little for it."""
        from warehouse_sim.estimators.pose.densefusion.calibrate import LEAST_SAMPLES, calibrate

        if calibrate(run, data, progress=progress).curves:
            return ""
        return f"val shows too few objects (fewer than {LEAST_SAMPLES}) to tell errors from confidence"


_IMAGES: dict[Size, ImageConfig] = {
    "nano": ImageConfig(kind="unet", side_px=48, width=24),
    "small": ImageConfig(kind="psp-resnet18", side_px=64, width=32),
    "full": ImageConfig(kind="psp-resnet18", side_px=80, width=64),
}
_POINTS: dict[Size, PointConfig] = {
    "nano": PointConfig(count=256, local=(64, 128), pooled=(256, 512), pooling="average+max"),
    "small": PointConfig(count=256, local=(64, 128), pooled=(512, 1024), pooling="average+max"),
    "full": PointConfig(count=500, local=(64, 128), pooled=(512, 1024), pooling="average"),
}
_HEADS: dict[Size, HeadConfig] = {
    "nano": HeadConfig(widths=(256, 128), shared=True, training_points=64),
    "small": HeadConfig(widths=(320, 128, 64), shared=False, training_points=128),
    "full": HeadConfig(widths=(640, 256, 128), shared=False),
}
_REFINERS: dict[Size, RefinerConfig] = {
    "nano": RefinerConfig(local=(32, 64), pooled=(128, 256), widths=(128, 64)),
    "small": RefinerConfig(local=(64, 128), pooled=(256, 512), widths=(256, 128)),
    "full": RefinerConfig(local=(64, 128), pooled=(512, 1024), widths=(512, 128)),
}
# The two middle fusions differ in the embedding of the attention alone.
_ATTENTION: dict[Size, tuple[AttentionConfig, AttentionConfig]] = {
    "nano": (AttentionConfig(32, heads=4), AttentionConfig(128, heads=4)),
    "small": (AttentionConfig(64, heads=4), AttentionConfig(256, heads=8)),
    "full": (AttentionConfig(64, heads=4), AttentionConfig(256, heads=8)),
}


def _config(size: Size, paper: bool, *images: tuple[Reading, ...]) -> DenseFusionConfig:
    """Return a network with one image branch for each of ``images``, named by what it reads."""
    branches = tuple(replace(_IMAGES[size], reads=reads) for reads in images)
    config = DenseFusionConfig(_POINTS[size], _HEADS[size], _REFINERS[size], branches)
    return as_original(config) if paper else config


def as_original(config: DenseFusionConfig) -> DenseFusionConfig:
    """Return the same network with the quirks of Wang et al.'s code, for parity."""
    return replace(
        config,
        points=replace(config.points, pooling="average"),
        heads=replace(config.heads, shared=False, class_bias=False, training_points=None),
        refiner=replace(config.refiner, pooling="average", shared=False, class_bias=False, both_layers=True),
        images=tuple(replace(image, paper=True) for image in config.images),
    )


def _fused(size: Size, paper: bool = False) -> DenseFusionConfig:
    return _config(size, paper, ("rgb",))


def _early(size: Size, paper: bool = False) -> DenseFusionConfig:
    return _config(size, paper, ("rgb", "depth"))


def _middle_1(size: Size, paper: bool = False) -> DenseFusionConfig:
    return replace(_config(size, paper, ("rgb",), ("depth",)), fusion=_ATTENTION[size][0])


def _middle_2(size: Size, paper: bool = False) -> DenseFusionConfig:
    return replace(_config(size, paper, ("rgb",), ("depth",)), fusion=_ATTENTION[size][1])


def _depth(size: Size, paper: bool = False) -> DenseFusionConfig:
    return _config(size, paper, ("depth",))


def _cloud_only(size: Size, paper: bool = False) -> DenseFusionConfig:
    return _config(size, paper)


def _coordinates(size: Size, paper: bool = False) -> DenseFusionConfig:
    config = _config(size, paper, ("rgb",))
    # One trunk at any size: coordinates and their scale are one prediction.
    return replace(config, heads=replace(config.heads, shared=True, predicts="coordinates"))


DENSEFUSION = Method("densefusion", "pixel-wise fusion of colour and cloud", "RGB crop + point cloud", network=_fused)
DENSEFUSION_EARLY = Method(
    "densefusion-early",
    "colour and depth joined before the first layer",
    "RGB + depth crop + point cloud",
    network=_early,
)
DENSEFUSION_MIDDLE_1 = Method(
    "densefusion-middle-1",
    "colour and depth fused by attention over the points, small embedding",
    "RGB crop + depth crop + point cloud",
    network=_middle_1,
)
DENSEFUSION_MIDDLE_2 = Method(
    "densefusion-middle-2",
    "colour and depth fused by attention over the points, large embedding",
    "RGB crop + depth crop + point cloud",
    network=_middle_2,
)
DENSEFUSION_DEPTH = Method(
    "densefusion-depth", "the depth image in place of colour", "depth crop + point cloud", network=_depth
)
DENSEFUSION_POINTCLOUD = Method("densefusion-pointcloud", "the cloud alone", "point cloud", network=_cloud_only)
OBJECT_COORDINATES = Method(
    "object-coordinates",
    "object coordinates at each point and a weighted least-squares pose",
    "RGB crop + point cloud",
    network=_coordinates,
)
