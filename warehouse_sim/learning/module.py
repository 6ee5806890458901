"""One training step and one validation of a network of the DenseFusion family, for Lightning."""

import time
from typing import Any

import lightning
import torch
from jaxtyping import Float, Int
from torch import Tensor

from warehouse_sim.learning.batch import Batch, draw_batch
from warehouse_sim.learning.clock import Clock, learning_rate_factor
from warehouse_sim.learning.crop_set import CropSet
from warehouse_sim.learning.losses import confidence_loss, hypotheses_distance, refined_distance
from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.networks.heads import Hypotheses
from warehouse_sim.learning.objects import ShapeTensors
from warehouse_sim.learning.rotations import matrix_from_quat_wxyz
from warehouse_sim.learning.settings import TrainConfig

THRESHOLDS = (0.02, 0.05, 0.10)
"""Accuracy thresholds of the validation, in diameters."""


class PoseTraining(lightning.LightningModule):
    """Train the heads on every point's pose, and in the later part of the run the refiner on the most confident one.

    Args:
        network: What is trained.
        shapes: Shapes of the network's classes.
        config: Settings.
        clock: Progress of the run.
        crops: Crop sets by split, "train" and "val".
    """

    def __init__(
        self, network: DenseFusion, shapes: ShapeTensors, config: TrainConfig, clock: Clock, crops: dict[str, CropSet]
    ) -> None:
        super().__init__()
        self.network, self.config, self.clock = network, config, clock
        self._shapes, self._crops = shapes, crops
        self._errors: list[Tensor] = []
        self._validation_start = 0.0
        self.train_loss, self.metrics = float("nan"), dict[str, float]()

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Return AdamW; the learning rate follows the clock, not a step count."""
        config = self.config
        return torch.optim.AdamW(self.network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay)

    def on_fit_start(self) -> None:
        """Move what the batches are drawn from to the device of the network."""
        self._shapes = self._shapes.to(self.device)
        self._crops = {split: crops.to(self.device) for split, crops in self._crops.items()}

    def on_train_batch_start(self, batch: Any, batch_idx: int) -> None:
        """Set the learning rate for this step."""
        fraction = self.clock.fraction(self.global_step)
        factor = learning_rate_factor(fraction, self.global_step, self.config.warmup_steps)
        for group in self.trainer.optimizers[0].param_groups:
            group["lr"] = self.config.learning_rate * factor

    def training_step(self, index: Int[Tensor, " b"], batch_idx: int) -> Float[Tensor, ""]:
        """Return the loss on the crops ``index``, disturbed afresh."""
        generator = self._generator(self.global_step + 1)
        batch = self._draw("train", index, generator, disturbed=True)
        hypotheses, colour = self._propose(batch)
        distance = hypotheses_distance(hypotheses, *_truth(batch), self._shapes)
        loss = confidence_loss(distance, hypotheses.logit, self.config.confidence_weight)
        if self.clock.fraction(self.global_step) >= self.config.refiner_start:
            refined = self._refine(*most_confident(hypotheses), batch, colour)
            loss = loss + sum(pose.mean() for pose in refined)
        self.train_loss = float(loss.detach())
        return loss

    def on_validation_epoch_start(self) -> None:
        """Forget the previous validation."""
        self._errors, self._validation_start = [], time.monotonic()

    def validation_step(self, index: Int[Tensor, " b"], batch_idx: int) -> None:
        """Collect the distance of the most confident pose of each crop, before and after the refiner."""
        batch = self._draw("val", index, self._generator(0), disturbed=False)
        hypotheses, colour = self._propose(batch)
        pose = most_confident(hypotheses)
        before = refined_distance(*pose, *_truth(batch), self._shapes)
        after = self._refine(*pose, batch, colour)
        self._errors.append(torch.stack([before, after[-1] if after else before], dim=1) * batch.scale[:, None])

    def on_validation_epoch_end(self) -> None:
        """Sum up: median RMS surface distance and shares below each threshold."""
        before, after = torch.cat(self._errors).unbind(dim=1)
        relative = after / self._crops["val"].diameter
        self.metrics = {"val_median_mm": _median_mm(after), "val_median_unrefined_mm": _median_mm(before)}
        for threshold in THRESHOLDS:
            name = f"val_within_{round(100 * threshold)}_percent"
            self.metrics[name] = 100.0 * float((relative < threshold).float().mean())
        # The last validation comes after the last step: keep its time, and some for writing the files.
        self.clock.reserve(1.0 + 1.2 * (time.monotonic() - self._validation_start))

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Keep the time that is already used up."""
        checkpoint["clock"] = self.clock.state()

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Continue the clock."""
        self.clock.continue_from(checkpoint["clock"])

    def _generator(self, stream: int) -> torch.Generator:
        # One stream a step, so that a resumed run disturbs its samples as an uninterrupted one would.
        return torch.Generator(self.device).manual_seed(self.config.seed * 1_000_003 + stream)

    def _draw(self, split: str, index: Tensor, generator: torch.Generator, disturbed: bool) -> Batch:
        augment = self.config.augment if disturbed else None
        count = self.network.config.points.count
        return draw_batch(self._crops[split], index.to(self.device), count, generator, augment)

    def _propose(self, batch: Batch) -> tuple[Hypotheses, Tensor | None]:
        colour = self.network.embed(batch.rgb, batch.pixel)
        return self.network(batch.points, colour, batch.class_index), colour

    def _refine(self, rotation: Tensor, translation: Tensor, batch: Batch, colour: Tensor | None) -> list[Tensor]:
        distances = []
        for _ in range(self.config.refiner_iterations):
            rotation, translation = self.network.refine(rotation, translation, batch.points, colour, batch.class_index)
            distances.append(refined_distance(rotation, translation, *_truth(batch), self._shapes))
        return distances


def most_confident(hypotheses: Hypotheses) -> tuple[Float[Tensor, "b 3 3"], Float[Tensor, "b 3"]]:
    """Return the pose of each object's most confident point."""
    rows = torch.arange(len(hypotheses.logit), device=hypotheses.logit.device)
    best = hypotheses.logit.argmax(dim=1)
    return matrix_from_quat_wxyz(hypotheses.quat_wxyz[rows, best]), hypotheses.translation[rows, best]


def _truth(batch: Batch) -> tuple[Tensor, Tensor, Tensor]:
    return batch.rotation, batch.translation, batch.class_index


def _median_mm(distance: Float[Tensor, " k"]) -> float:
    return 1000.0 * float(distance.median())
