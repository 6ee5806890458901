"""Observers of a training, the state that they are given, and the one that forecasts how many steps will fit."""

import logging
import math
import time
from dataclasses import dataclass, field

import torch
from torch import Tensor

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.compute import Precision
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


LEAST_STEPS = 100
"""Fewer hardly train anything."""
_MEASURED_STEPS = 5
_MEASURED_FRACTION = 0.05
"""As many steps, or as much of the time, are measured before the forecast."""

log = logging.getLogger(__name__)


class StepForecast(Observer):
    """Warn when fewer than ``LEAST_STEPS`` steps will fit into the time; reject when none does.

    Stands behind the other observers, whose time counts.

    Args:
        minutes: Time of the run, as it was set.
    """

    def __init__(self, minutes: float) -> None:
        self._minutes, self._used, self._start, self._reported = minutes, 0.0, 0.0, False

    def on_start(self, state: TrainingState) -> None:
        """Begin to measure, unless an earlier session of the run has reported.

        Raises:
            TrainingError: Reading and the first validation have used up the time of a run that begins.
        """
        self._used, self._start, self._reported = state.clock.spent(), time.monotonic(), state.step > 0
        if not self._reported and state.clock.left() == 0.0:
            raise TrainingError(
                f"reading and a first validation took {self._used:.0f} s, which leaves nothing of max_minutes "
                f"{self._minutes:.2g} to train in; resume the run, which finds the crops that were cut, or allow more"
            )

    def on_step(self, state: TrainingState) -> None:
        """Report once the pace is known, with all that comes between two steps."""
        if state.step >= _MEASURED_STEPS or state.clock.fraction_of_time() > _MEASURED_FRACTION:
            self._report(state)

    def on_end(self, state: TrainingState) -> None:
        """Report on a training that ended before its pace was known."""
        self._report(state)

    def _report(self, state: TrainingState) -> None:
        if self._reported:
            return
        self._reported = True
        pace = (time.monotonic() - self._start) / state.step
        validating = (state.config.validations - 1) * state.validation_seconds
        steps = state.step + int(max(0.0, state.clock.left() - validating) / pace)
        if steps >= min(LEAST_STEPS, state.clock.max_steps or LEAST_STEPS):
            return
        needed = self._used + validating + state.clock.reserved + LEAST_STEPS * pace
        log.warning(
            "about %d steps of %.2g s fit into max_minutes %.2g, of which reading and a first validation took %.0f s; "
            "fewer than %d hardly train anything: allow %.1f minutes or more",
            *(steps, pace, self._minutes, self._used, LEAST_STEPS, math.ceil(needed / 6.0) / 10.0),
        )
