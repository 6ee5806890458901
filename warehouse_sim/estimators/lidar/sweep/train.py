"""What the training of a detector of sweeps has of its own: its samples, and where its weights may come from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.job import BoxJob
from warehouse_sim.estimators.detectors.preparation import Prepared, known_classes, network_config, require_wanted
from warehouse_sim.estimators.detectors.task import BoxTask, Inputs
from warehouse_sim.estimators.detectors.yolov5.assignment import Targets
from warehouse_sim.estimators.detectors.yolov5.losses import detection_loss
from warehouse_sim.estimators.images.compose import Sample
from warehouse_sim.estimators.images.order import GroupedOrder
from warehouse_sim.estimators.lidar.sweep.compose import composed_sweep, plain_sweep
from warehouse_sim.estimators.lidar.sweep.network import DEPTH_CHANNELS, SweepNetwork
from warehouse_sim.estimators.lidar.sweep.range_image import SweepGrid
from warehouse_sim.estimators.lidar.sweep.rows import load_sweeps
from warehouse_sim.estimators.lidar.sweep.run_config import SweepRunConfig, read_config
from warehouse_sim.estimators.lidar.sweep.settings import SweepDetectorConfig
from warehouse_sim.learning.job import start_from
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import DatasetSource, StartingWeights, package_version, read_weights
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.settings import Progress
from warehouse_sim.resources import model_dir

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
            boxes = detection_loss(self.network, raw, targets, self.config.loss)
            return boxes + self.config.pixels * pixel_loss(raw.pixels.float(), planes[:, 2])


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


def prepare_sweeps(
    data: Sequence[Path], config: SweepDetectorConfig, cache: Path | None, progress: Progress | None
) -> Prepared:
    """Read the sweeps of train and val, and find the classes.

    Args:
        data: Dataset folders.
        config: Settings.
        cache: Folder to keep range images in; None keeps them in memory.
        progress: Called with what is read.

    Raises:
        DatasetError: A folder is no dataset that can be read, or holds no sweeps.
        TrainingError: A split is empty, or a class is not there.
    """
    if not data:
        raise TrainingError("there is nothing to train on: name at least one dataset folder")
    readers = [DatasetReader(folder) for folder in data]
    found: dict[str, list[Arrays]] = {}
    for split in ("train", "val"):
        parts = [load_sweeps(reader, split, config.sweep, config.workers, cache, progress) for reader in readers]
        found[split] = [arrays for arrays in parts if arrays is not None]
    classes, class_of = known_classes(readers, found["train"], config)
    require_wanted(found, data, classes, class_of, config, "--wanted.points")
    sources = tuple(DatasetSource(reader.root.resolve().name, reader.digest) for reader in readers)
    return Prepared(found, class_of, classes, config.sweep, sources)


@dataclass(frozen=True)
class SweepJob(BoxJob):
    """A training of a detector of sweeps."""

    config: SweepDetectorConfig

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size != "small"

    def read_old(self) -> SweepRunConfig:
        """Read the configuration of the run that is gone on with."""
        return read_config(self.run)

    def prepared(self, progress: Progress | None = None) -> Prepared:
        """Read the sweeps."""
        return prepare_sweeps(self.data, self.config, self.cache, progress)

    def make(self, prepared: Prepared, order: GroupedOrder) -> tuple[SweepTask, SweepRunConfig]:
        """Return the training of a fresh network with anchors for its data, and the resolved configuration."""
        sizes = network_config(prepared, self.config, self.config.size)
        network = SweepNetwork(sizes, self.config.sweep)
        task = SweepTask(network, self.config, prepared.images, prepared.class_of, order)
        names = self.name, package_version(), prepared.datasets, prepared.classes
        return task, SweepRunConfig(*names, self.config.sweep, sizes, self.config)

    def begin_with(self, init: str | Path, network: nn.Module, log: RunLog) -> StartingWeights:
        """Copy the weights of a detector of sweeps, or of depth images, whose channels are this one's first."""
        started = start_from(init, network)
        given, own = read_weights(model_dir(init))[_FIRST], network.state_dict()[_FIRST]
        if given.shape[1] == DEPTH_CHANNELS and given.shape[0] == own.shape[0]:
            # What the depth images lack, it begins to look at from nothing.
            with torch.no_grad():
                own[:, :DEPTH_CHANNELS], own[:, DEPTH_CHANNELS:] = given, 0.0
            log.note(f"the first {DEPTH_CHANNELS} of {own.shape[1]} channels begin as those of depth images")
        return started
