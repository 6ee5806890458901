"""Observers of a training and the state that they are given."""

import math
from dataclasses import dataclass, field

import torch
from torch import Tensor

from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.precision import Precision
from warehouse_sim.learning.settings import LoopConfig


@dataclass
class TrainingState:
    """Where a training stands."""

    config: LoopConfig
    clock: Clock
    device: torch.device
    precision: Precision
    step: int = 0
    """Steps done."""
    stretch: int = 0
    """Validations done, without the one before the first step."""
    last_loss: Tensor = field(default_factory=lambda: torch.tensor(math.nan))
    """Loss of the last step, on its device."""
    learning_rate: float = 0.0
    """Of the last step."""
    metrics: dict[str, float] = field(default_factory=dict)
    """What the last validation said."""
    validation_seconds: float = 0.0
    """How long the last validation took."""

    @property
    def loss(self) -> float:
        """Loss of the last step; NaN before the first."""
        return float(self.last_loss)

    @property
    def fraction(self) -> float:
        """Fraction of the training that is over, 0-1."""
        return self.clock.fraction(self.step)


class Observer:
    """Notified of what happens in a training; each method does nothing unless it is written."""

    def on_start(self, state: TrainingState) -> None:
        """Follow the first validation, or the loading of a checkpoint."""

    def on_step(self, state: TrainingState) -> None:
        """Follow a step."""

    def on_validation(self, state: TrainingState) -> None:
        """Follow a validation, but not that before the first step."""

    def on_end(self, state: TrainingState) -> None:
        """Follow the last validation."""
