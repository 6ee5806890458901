"""The named members of the DenseFusion family and their widths at each size.

``nano`` trains in minutes on a CPU, ``full`` has the widths of Wang et al., "DenseFusion", CVPR 2019.
"""

from warehouse_sim.learning.methods import Method, Size
from warehouse_sim.learning.networks.densefusion import DenseFusionConfig
from warehouse_sim.learning.networks.heads import HeadConfig
from warehouse_sim.learning.networks.image import ImageConfig
from warehouse_sim.learning.networks.points import PointConfig
from warehouse_sim.learning.networks.refiner import RefinerConfig

_IMAGES: dict[Size, ImageConfig] = {
    "nano": ImageConfig(kind="unet", side_px=48, width=16),
    "small": ImageConfig(kind="psp-resnet18", side_px=64, width=32),
    "full": ImageConfig(kind="psp-resnet18", side_px=80, width=64),
}
_POINTS: dict[Size, PointConfig] = {
    "nano": PointConfig(count=256, local=(64, 128), pooled=(256, 512), pooling="average+max"),
    "small": PointConfig(count=256, local=(64, 128), pooled=(512, 1024), pooling="average+max"),
    "full": PointConfig(count=500, local=(64, 128), pooled=(512, 1024), pooling="average"),
}
_HEADS: dict[Size, HeadConfig] = {
    "nano": HeadConfig(widths=(256, 128), shared=True),
    "small": HeadConfig(widths=(320, 128, 64), shared=False),
    "full": HeadConfig(widths=(640, 256, 128), shared=False),
}
_REFINERS: dict[Size, RefinerConfig] = {
    "nano": RefinerConfig(local=(32, 64), pooled=(128, 256), widths=(128, 64)),
    "small": RefinerConfig(local=(64, 128), pooled=(256, 512), widths=(256, 128)),
    "full": RefinerConfig(local=(64, 128), pooled=(512, 1024), widths=(512, 128)),
}


def _fused(size: Size) -> DenseFusionConfig:
    return DenseFusionConfig(_POINTS[size], _HEADS[size], _REFINERS[size], image=_IMAGES[size])


def _cloud_only(size: Size) -> DenseFusionConfig:
    return DenseFusionConfig(_POINTS[size], _HEADS[size], _REFINERS[size], image=None)


DENSEFUSION = Method("densefusion", "pixel-wise fusion of colour and cloud", "RGB crop + point cloud", _fused)
DENSEFUSION_POINTCLOUD = Method("densefusion-pointcloud", "the cloud alone", "point cloud", _cloud_only)
