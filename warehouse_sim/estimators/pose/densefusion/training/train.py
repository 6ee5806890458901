"""The training of networks of the family: a step, a validation, and the job with its crops, streams and mean pose."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.batch import Batch, sample_batch
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet
from warehouse_sim.estimators.pose.densefusion.losses import loss_distance, pose_distance
from warehouse_sim.estimators.pose.densefusion.methods import Method
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.networks.interface import Proposal
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors, dataset_meshes, shape_tensors, write_meshes
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.preparation import (
    Prepared,
    prepare,
    settings_from,
    start_at_mean_rotation,
    start_from,
)
from warehouse_sim.estimators.pose.densefusion.training.streamed_crops import StreamedCrops, sampling_weights
from warehouse_sim.learning.clock import learning_rate_factor
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.loop import Order, Task
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import RunConfig, Source
from warehouse_sim.learning.samples.order import SampleOrder, step_seed
from warehouse_sim.learning.settings import Progress

_REFINER_RATE = 0.3
"""Learning rate of a refiner that is trained alone, as a multiple of that of the rest, as in the original; it falls
along a cosine of its own."""


def refiner_begins(config: TrainConfig) -> float:
    """Return the fraction of the run after which the refiner is trained, 0-1."""
    return 0.0 if config.phase == "refiner" else config.refiner_start


def refiner_alone(config: TrainConfig, fraction: float) -> bool:
    """Tell whether nothing but the refiner is trained when a fraction of the run is over."""
    return config.phase != "joint" and fraction >= refiner_begins(config)


def rate_factor(config: TrainConfig, fraction: float, step: int) -> float:
    """Return the factor on the learning rate; each phase has a cosine of its own.

    Args:
        config: Settings.
        fraction: Fraction of the run that is over, 0-1.
        step: Steps done.
    """
    if config.phase == "joint":
        return learning_rate_factor(fraction, step, config.warmup_steps)
    start = refiner_begins(config)
    if refiner_alone(config, fraction):
        part = (fraction - start) / (1.0 - start) if start < 1.0 else 1.0
        return _REFINER_RATE * learning_rate_factor(part, step, config.warmup_steps)
    return learning_rate_factor(fraction / start, step, config.warmup_steps)


THRESHOLDS = (0.02, 0.05, 0.10)
"""Accuracy thresholds of the validation, in diameters."""
_VALIDATION_BATCH = 64


class PoseTask(Task):
    """Train the heads on every point's pose, and in the later part of the run the refiner on the most confident one.

    A refiner that is trained alone sees what the network says in prediction: of all points, nothing dropped.

    Args:
        network: What is trained.
        shapes: Shapes of the network's classes.
        config: Settings.
        crops: Crop sets by split, "train" and "val"; the former may be those of a stream.
        crop: How they were cut; needed for those with surroundings.
    """

    network: DenseFusion

    def __init__(
        self,
        network: DenseFusion,
        shapes: ShapeTensors,
        config: TrainConfig,
        crops: Mapping[str, CropSet | StreamedCrops],
        crop: CropConfig | None = None,
    ) -> None:
        super().__init__(network)
        self.config, self._shapes, self._crops, self._crop = config, shapes, crops, crop
        self._device = torch.device("cpu")

    def move_samples(self, device: torch.device) -> None:
        """Move what the batches are drawn from to a device."""
        self._device, self._shapes = device, self._shapes.to(device)
        self._crops = {split: crops.to(device) for split, crops in self._crops.items()}

    def forward(self, index: Int[Tensor, " b"], part: slice, step: int, fraction: float) -> Float[Tensor, ""]:
        """Return the loss on the crops ``index``, disturbed afresh."""
        batch, network = self._draw("train", index, step + 1, part), self.network
        alone = refiner_alone(self.config, fraction)
        if alone:
            network.eval()
        with torch.set_grad_enabled(not alone):
            embedding = network.embed(batch.inputs)
            proposal = network.propose(batch.inputs, embedding)
        losses = [] if alone else [network.loss(proposal, batch.gt, self._shapes, self.config.loss)]
        if fraction >= refiner_begins(self.config):
            # Each correction by itself, as the original: the next begins where this one ends, without its gradient.
            for pose in self._corrections(network, proposal, batch, embedding):
                rotation, translation = (value[:, None] for value in pose)
                losses.append(loss_distance(rotation, translation, batch.gt, self._shapes, self.config.loss).mean())
        return torch.stack(losses).sum()

    def rate(self, fraction: float, step: int) -> float:
        """Return the factor on the learning rate of a step."""
        return rate_factor(self.config, fraction, step)

    def validate(self, network: nn.Module) -> dict[str, float]:
        """Return the median RMS surface distance of the most confident poses, and shares below each threshold."""
        assert isinstance(network, DenseFusion)
        crops = self._crops["val"]
        assert isinstance(crops, CropSet)
        errors = [self._errors(network, index) for index in torch.arange(len(crops)).split(_VALIDATION_BATCH)]
        before, after = torch.cat(errors).unbind(dim=1)
        metrics = {"val_median_mm": _median_mm(after), "val_median_unrefined_mm": _median_mm(before)}
        for threshold in THRESHOLDS:
            within = 100.0 * float((after / crops.diameter < threshold).float().mean())
            metrics[f"val_within_{round(100 * threshold)}_percent"] = within
        return metrics

    def _errors(self, network: DenseFusion, index: Int[Tensor, " b"]) -> Float[Tensor, "b 2"]:
        """Return the distance (m) of the most confident pose of each crop, before and after the refiner."""
        batch = self._draw("val", index, 0)
        embedding = network.embed(batch.inputs)
        proposal = network.propose(batch.inputs, embedding)
        before = self._distance(*proposal.hypotheses.most_confident(), batch)
        after = [self._distance(*one, batch) for one in self._corrections(network, proposal, batch, embedding)]
        return torch.stack([before, after[-1] if after else before], dim=1) * batch.scale[:, None]

    def _draw(self, split: str, index: Tensor, stream: int, part: slice = slice(None)) -> Batch:
        # One stream a step, so that a resumed run disturbs its samples as an uninterrupted one would.
        generator = torch.Generator(self._device).manual_seed(step_seed(self.config.seed, stream))
        count, upright = self.network.config.points.count, self.network.config.upright
        augment = None
        if split == "train":
            augment, count = self.config.augment, self.config.points or count
        crops, index = self._crops[split], index.to(self._device)
        # Mixed precision is for the layers: in 16 bits points and true poses would be off by millimetres.
        with torch.autocast(self._device.type, enabled=False):
            return sample_batch(crops, index, count, generator, augment, part, self._crop, upright)

    def _corrections(
        self, network: DenseFusion, proposal: Proposal, batch: Batch, embedding: Tensor | None
    ) -> list[tuple[Tensor, Tensor]]:
        poses = [proposal.hypotheses.most_confident()]
        for _ in range(self.config.refiner_iterations):
            poses.append(network.refine(*poses[-1], batch.inputs, embedding, proposal))
        return poses[1:]

    def _distance(self, rotation: Tensor, translation: Tensor, batch: Batch) -> Float[Tensor, " b"]:
        return pose_distance(rotation[:, None], translation[:, None], batch.gt, self._shapes)[:, 0]


def _median_mm(distance: Float[Tensor, " k"]) -> float:
    return 1000.0 * float(distance.median())


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

    def begin_with(self, init: str | Path, started: Started, log: RunLog) -> Source:
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
        crops["train"] = order = streamed
    else:
        train = prepared.crops["train"]
        weights = sampling_weights(train.class_index, prepared.classes, config.balance)
        order = SampleOrder(len(train), config.batch, config.seed, weights)
    return PoseTask(network, shape_tensors(prepared.config.objects), config, crops, prepared.config.crop), order
