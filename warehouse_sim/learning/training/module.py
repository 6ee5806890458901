"""One training step and one validation of a network of the DenseFusion family, for Lightning."""

import time
from typing import Any

import lightning
import torch
from jaxtyping import Float, Int
from torch import Tensor

from warehouse_sim.learning.crops import CropSet
from warehouse_sim.learning.crops.batch import Batch, draw_batch
from warehouse_sim.learning.losses import pose_distance
from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.objects import ShapeTensors
from warehouse_sim.learning.settings import SymmetryLoss, TrainConfig
from warehouse_sim.learning.training.clock import Clock, learning_rate_factor

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
        self.share = slice(None)
        """The samples of a step that this process takes."""
        self._errors: list[Tensor] = []
        self._validation_start = 0.0
        self.validation_seconds = 0.0
        """How long the last validation took."""
        self._loss = torch.tensor(float("nan"))
        self.metrics = dict[str, float]()

    @property
    def train_loss(self) -> float:
        """Loss of the last training step."""
        return float(self._loss)

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Return AdamW; the learning rate follows the clock, not a step count."""
        config = self.config
        return torch.optim.AdamW(
            self.network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay, fused=True
        )

    def configure_gradient_clipping(
        self,
        optimizer: torch.optim.Optimizer,
        gradient_clip_val: float | None = None,
        gradient_clip_algorithm: str | None = None,
    ) -> None:
        """Clip by norm here: Lightning refuses to for a fused optimiser, on account of 16-bit floats with scaling."""
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), self.config.clip_norm)

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
        batch = self._draw("train", index, self._generator(self.global_step + 1), disturbed=True)
        embedding = self.network.embed(batch.inputs)
        proposal = self.network.propose(batch.inputs, embedding)
        loss = self.network.loss(proposal, batch.truth, self._shapes, self.config.loss)
        if self.clock.fraction(self.global_step) >= self.config.refiner_start:
            for pose in self._corrections(*proposal.hypotheses.most_confident(), batch, embedding):
                loss = loss + self._distance(*pose, batch, self.config.loss.symmetry).mean()
        self._loss = loss.detach()
        return loss

    def on_validation_epoch_start(self) -> None:
        """Forget the previous validation."""
        self._errors, self._validation_start = [], time.monotonic()

    def validation_step(self, index: Int[Tensor, " b"], batch_idx: int) -> None:
        """Collect the distance of the most confident pose of each crop, before and after the refiner."""
        batch = self._draw("val", index, self._generator(0), disturbed=False)
        embedding = self.network.embed(batch.inputs)
        pose = self.network.propose(batch.inputs, embedding).hypotheses.most_confident()
        before = self._distance(*pose, batch, "group")
        after = [self._distance(*refined, batch, "group") for refined in self._corrections(*pose, batch, embedding)]
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
        self.validation_seconds = time.monotonic() - self._validation_start
        self.clock.reserve(1.0 + 1.2 * self.validation_seconds)

    def on_train_epoch_end(self) -> None:
        """Take no further stretch when the time is up, be it before the last one."""
        self.trainer.should_stop = self.clock.fraction(self.global_step) >= 1.0

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
        # Mixed precision is for the layers: in 16 bits points and true poses would be off by millimetres.
        with torch.autocast(self.device.type, enabled=False):
            share = self.share if disturbed else slice(None)
            return draw_batch(self._crops[split], index.to(self.device), count, generator, augment, share)

    def _corrections(
        self, rotation: Tensor, translation: Tensor, batch: Batch, embedding: Tensor | None
    ) -> list[tuple[Tensor, Tensor]]:
        poses = [(rotation, translation)]
        for _ in range(self.config.refiner_iterations):
            poses.append(self.network.refine(*poses[-1], batch.inputs, embedding))
        return poses[1:]

    def _distance(
        self, rotation: Tensor, translation: Tensor, batch: Batch, symmetry: SymmetryLoss
    ) -> Float[Tensor, " b"]:
        return pose_distance(rotation[:, None], translation[:, None], batch.truth, self._shapes, symmetry)[:, 0]


def _median_mm(distance: Float[Tensor, " k"]) -> float:
    return 1000.0 * float(distance.median())
