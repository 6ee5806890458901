"""What the training of the package's own detector has of its own: anchors for its data, its loss."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.detectors.boxes import BoxRun
from warehouse_sim.estimators.detectors.job import BoxJob
from warehouse_sim.estimators.detectors.preparation import Prepared, wanted_sizes
from warehouse_sim.estimators.detectors.settings import BoxTrainingConfig
from warehouse_sim.estimators.detectors.task import BoxTask, ImageBoxTask, Inputs
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
from warehouse_sim.estimators.detectors.yolov5.settings import DetectorConfig, DetectorSize

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
            return detection_loss(self.network, raw, targets, self.config.loss)


def network_config(prepared: Prepared, config: BoxTrainingConfig, size: DetectorSize) -> DetectorNetworkConfig:
    """Return the network of a size for the classes, with anchors for the boxes of the training data."""
    rng = np.random.default_rng(config.seed)
    sizes = rng.permutation(wanted_sizes(prepared.images["train"], prepared.class_of, config))[:_MOST_CLUSTERED]
    fit = cluster_anchors(sizes, _ANCHORS_A_LEVEL * len(STRIDES), rng)
    anchors = tuple((round(float(w), 2), round(float(h), 2)) for w, h in fit.anchors_wh)
    return DetectorNetworkConfig(WIDTHS[size], DEPTH, len(prepared.classes), anchors)


@dataclass(frozen=True)
class DetectorJob(BoxJob):
    """A training of the detector of this package."""

    config: DetectorConfig

    run_config: ClassVar[type[BoxRun]] = DetectorRun
    task: ClassVar[type[BoxTask]] = DetectionTask

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size != "small"

    def sizes(self, prepared: Prepared) -> DetectorNetworkConfig:
        """Return widths by size, and anchors for the data."""
        return network_config(prepared, self.config, self.config.size)
