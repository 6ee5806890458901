"""What the training of a network of the family has of its own: crops, streams, a start at the mean pose, CAD."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import torch

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet
from warehouse_sim.estimators.pose.densefusion.methods import Method
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.objects import dataset_meshes, shape_tensors, write_meshes
from warehouse_sim.estimators.pose.densefusion.run_config import PoseRun
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.preparation import Prepared, prepare
from warehouse_sim.estimators.pose.densefusion.training.start import settings_from, start_at_mean_rotation, start_from
from warehouse_sim.estimators.pose.densefusion.training.streamed_crops import (
    StreamedCrops,
    StreamOrder,
    sampling_weights,
)
from warehouse_sim.estimators.pose.densefusion.training.task import PoseTask
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.loop import Order
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import RunConfig, StartingWeights
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.settings import Progress


@dataclass(frozen=True)
class PoseJob(TrainingJob):
    """A training of a network of the family."""

    method: Method
    config: TrainConfig

    run_config: ClassVar[type[RunConfig]] = PoseRun
    samples: ClassVar[str] = "crops"
    kept: ClassVar[str] = "crops"
    watched: ClassVar[tuple[str, str]] = ("val_within_5_percent", "validation within 5 % of diameter {:.1f} %")

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size == "nano"

    def settings(self, start: str | Path | None) -> TrainConfig:
        """Return the settings, those left at their defaults as of the weights that training begins with.

        Raises:
            TrainingError: The refiner alone is to be trained, and nothing says on top of what.
        """
        if self.config.phase == "refiner" and not start:
            raise TrainingError(
                "phase refiner trains on top of a network: name it with --init, a bundled name or a run"
            )
        return settings_from(start, self.config) if start else self.config

    def start(self, progress: Progress | None = None) -> Started:
        """Cut the crops and make a network that proposes about the mean pose of its data."""
        prepared = prepare(self.method, self.data, self.config, self.cache_dir, progress, self.open_stream)
        config = prepared.config
        torch.manual_seed(self.config.seed)
        network = config.make_network()
        start_at_mean_rotation(network, prepared.first_crops, config.objects)
        task, order = task_and_order(prepared, network)
        stream = self.config.stream
        remark = f"train: the stream of {stream.recipe}, seed {stream.seed}" if prepared.streamed else ""
        return Started(task, order, config, {split: len(crops) for split, crops in prepared.crops.items()}, remark)

    def begin_with(self, init: str | Path, started: Started, log: RunLog) -> StartingWeights:
        """Copy weights that were trained before; objects are matched by name."""
        assert isinstance(started.config, PoseRun)
        assert isinstance(started.task, PoseTask)
        only_refiner = self.config.phase == "refiner"
        return start_from(init, started.task.network, started.config.objects, all_known=only_refiner)

    def finish(self, started: Started) -> None:
        """Write the CAD surfaces of the objects."""
        assert isinstance(started.config, PoseRun)
        write_meshes(self.run, dataset_meshes(self.data, started.config.objects))


def task_and_order(prepared: Prepared, network: DenseFusion) -> tuple[PoseTask, Order]:
    """Return what trains a network on prepared crops, and the samples of each step."""
    config, streamed = prepared.config.train, prepared.streamed
    crops: dict[str, CropSet | StreamedCrops] = {**prepared.crops}
    order: Order
    if streamed:
        crops["train"] = streamed
        order = StreamOrder(streamed, config.batch, config.seed, prepared.classes, config.balance)
    else:
        train = prepared.crops["train"]
        weights = sampling_weights(train.class_index, prepared.classes, config.balance)
        order = SampleOrder(len(train), config.batch, config.seed, weights)
    return PoseTask(network, shape_tensors(prepared.config.objects), config, crops, prepared.config.crop), order
