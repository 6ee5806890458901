"""Settings of training the package's own detector, and its names; free of torch, so that a command line is quick."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from warehouse_sim.estimators.detectors.settings import AnyDetectorConfig, TrainableOnImages
from warehouse_sim.ranges import ranged

DetectorSize = Literal["pico", "nano", "small"]


@dataclass(frozen=True)
@ranged
class DetectorConfig(AnyDetectorConfig):
    """How a detector of this package is trained."""

    size: DetectorSize = "nano"
    """Widths of the network: nano and small are those of the original, pico is half of nano."""


@dataclass(frozen=True)
class TrainableDetector(TrainableOnImages):
    """A detector by what it reads."""

    settings: DetectorConfig = DetectorConfig()

    job: ClassVar[str] = "warehouse_sim.estimators.detectors.yolov5.train:DetectorJob"
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
    DetectorConfig(depth_source="lidar"),
)
