"""What the training of a detector of sweeps has of its own: its samples, and where its weights may come from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.detectors.preparation import Prepared, known_classes, require_wanted
from warehouse_sim.estimators.detectors.task import BoxJob, BoxTask, Inputs
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets
from warehouse_sim.estimators.detectors.yolov5.losses import detection_loss
from warehouse_sim.estimators.detectors.yolov5.network import BoxRun
from warehouse_sim.estimators.images.compose import Sample
from warehouse_sim.estimators.lidar.sweep.compose import composed_sweep, plain_sweep
from warehouse_sim.estimators.lidar.sweep.network import DEPTH_CHANNELS, SweepNetwork, SweepRun
from warehouse_sim.estimators.lidar.sweep.range_image import SweepGrid
from warehouse_sim.estimators.lidar.sweep.rows import load_sweeps
from warehouse_sim.estimators.lidar.sweep.settings import SweepDetectorConfig
from warehouse_sim.learning.job import Started, start_from
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import Source, read_weights
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.settings import Progress
from warehouse_sim.resources import model_dir

_PIXEL_WEIGHT = 0.5
"""Of telling pixels that show an object from others, beside the loss of boxes."""
_RARE = 3.0
"""Weight of a pixel that shows an object, against one that shows none."""
_FIRST = "pyramid.start.0.0.weight"
"""The first layer, which looks at the channels of the input."""


class SweepTask(BoxTask):
    """Train the detector on sectors of sweeps, validate it on whole turns; see ``BoxTask`` for the arguments."""

    network: SweepNetwork
    config: SweepDetectorConfig

    def composed(self, arrays: Arrays, row: int, rng: np.random.Generator, mosaics: bool) -> Sample:
        """Return a sector of a turn, or halves of two."""
        return composed_sweep(
            arrays, row, self.config.augment, SweepGrid(self.config.sweep), rng, mosaics, self._class_of
        )

    def plain(self, arrays: Arrays, row: int) -> Sample:
        """Return a whole turn, a little of it twice."""
        return plain_sweep(arrays, row, SweepGrid(self.config.sweep), self._class_of)

    def loss(self, inputs: Inputs, targets: Targets) -> Float[Tensor, ""]:
        """Return CIoU, objectness, classes and pixels, weighted."""
        raw = self.network(*inputs)
        planes = inputs[1]
        assert planes is not None
        with torch.autocast(self._device.type, enabled=False):
            boxes = detection_loss(self.network, raw, targets)
            return boxes + _PIXEL_WEIGHT * pixel_loss(raw.pixels.float(), planes[:, 2])


def pixel_loss(logits: Float[Tensor, "b h w"], shows: Float[Tensor, "b h w"]) -> Float[Tensor, ""]:
    """Return the mean cross-entropy over pixels with a reading; the few that show an object weigh more.

    Args:
        logits: Of showing one.
        shows: 1 or 0, NaN without a reading.
    """
    known = torch.isfinite(shows)
    gt = torch.where(known, shows, 0.0)
    weight = known * (1.0 + (_RARE - 1.0) * gt)
    loss = functional.binary_cross_entropy_with_logits(logits, gt, weight, reduction="sum")
    return loss / known.sum().clamp(min=1)


@dataclass(frozen=True)
class SweepJob(BoxJob):
    """A training of a detector of sweeps."""

    config: SweepDetectorConfig

    run_config: ClassVar[type[BoxRun]] = SweepRun
    task: ClassVar[type[BoxTask]] = SweepTask

    def prepared(self, readers: Sequence[DatasetReader], progress: Progress | None = None) -> Prepared:
        """Read the sweeps of train and val, and find the classes.

        Raises:
            DatasetError: A folder holds no sweeps.
            TrainingError: A split is empty, or a class is not there.
        """
        config, found = self.config, dict[str, list[Arrays]]()
        for split in ("train", "val"):
            parts = [
                load_sweeps(reader, split, config.sweep, config.workers, self.cache_dir, progress) for reader in readers
            ]
            found[split] = [arrays for arrays in parts if arrays is not None]
        classes, class_of = known_classes(readers, found["train"], config)
        require_wanted(found, readers, classes, class_of, config, "--wanted.points")
        return Prepared(found, class_of, classes, config.sweep)

    def begin_with(self, init: str | Path, started: Started, log: RunLog) -> Source:
        """Copy the weights of a detector of sweeps, or of depth images, whose channels are this one's first."""
        network = started.task.network
        begun = start_from(init, network)
        given, own = read_weights(model_dir(init))[_FIRST], network.state_dict()[_FIRST]
        if given.shape[1] == DEPTH_CHANNELS and given.shape[0] == own.shape[0]:
            # What the depth images lack, it begins to look at from nothing.
            with torch.no_grad():
                own[:, :DEPTH_CHANNELS], own[:, DEPTH_CHANNELS:] = given, 0.0
            log.note(f"the first {DEPTH_CHANNELS} of {own.shape[1]} channels begin as those of depth images")
        return begun
