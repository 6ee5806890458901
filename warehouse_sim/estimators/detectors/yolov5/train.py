"""What the training of the package's own detectors has of its own: anchors for its data, its loss."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.detectors.boxes import BoxRun
from warehouse_sim.estimators.detectors.preparation import Prepared, wanted_sizes
from warehouse_sim.estimators.detectors.task import BoxJob, BoxTask, ImageBoxTask, Inputs
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets, cluster_anchors
from warehouse_sim.estimators.detectors.yolov5.losses import detection_loss
from warehouse_sim.estimators.detectors.yolov5.network import (
    DEPTH,
    STRIDES,
    WIDTHS,
    DetectorNetwork,
    DetectorNetworkConfig,
    DetectorRun,
)
from warehouse_sim.estimators.detectors.yolov5.settings import DetectorConfig
from warehouse_sim.estimators.lidar.sweep.settings import SweepDetectorConfig

_ANCHORS_A_LEVEL = 3
_MOST_CLUSTERED = 20_000
"""Boxes that anchors are found from."""


class DetectionTask(ImageBoxTask):
    """Train the detector of this package."""

    network: DetectorNetwork
    config: DetectorConfig

    def loss(self, inputs: Inputs, targets: Targets) -> Float[Tensor, ""]:
        """Return CIoU, objectness and classes, weighted."""
        raw = self.network(*inputs)
        with torch.autocast(self._device.type, enabled=False):
            return detection_loss(self.network, raw, targets)


@dataclass(frozen=True)
class CellJob(BoxJob):
    """A training of any network that looks for boxes about the anchors of cells."""

    config: DetectorConfig | SweepDetectorConfig

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size != "small"

    def sizes(self, prepared: Prepared) -> DetectorNetworkConfig:
        """Return widths by size, and anchors for the boxes of the training data."""
        rng, boxes = np.random.default_rng(self.config.seed), prepared.images["train"]
        sizes = rng.permutation(wanted_sizes(boxes, prepared.class_of, self.config))[:_MOST_CLUSTERED]
        fit = cluster_anchors(sizes, _ANCHORS_A_LEVEL * len(STRIDES), rng)
        anchors = tuple((round(float(w), 2), round(float(h), 2)) for w, h in fit.anchors_wh)
        return DetectorNetworkConfig(WIDTHS[self.config.size], DEPTH, len(prepared.classes), anchors)


@dataclass(frozen=True)
class DetectorJob(CellJob):
    """A training of the detector of this package."""

    config: DetectorConfig

    run_config: ClassVar[type[BoxRun]] = DetectorRun
    task: ClassVar[type[BoxTask]] = DetectionTask
