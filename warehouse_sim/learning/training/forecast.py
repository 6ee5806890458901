"""Tell at the beginning of a training how far its time will reach."""

import logging
import math
import time
from typing import Any

import lightning

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.training.clock import Clock
from warehouse_sim.learning.training.module import PoseTraining

LEAST_STEPS = 100
"""Fewer hardly train anything."""
_MEASURED_STEPS = 5
_MEASURED_SHARE = 0.05
"""As many steps, or as much of the time, are measured before the forecast."""

log = logging.getLogger(__name__)


class StepForecast(lightning.Callback):
    """Warn when fewer than ``LEAST_STEPS`` steps will fit into the time; refuse when none does.

    Args:
        clock: The clock of the run.
        minutes: Time of the run, as it was set.
    """

    def __init__(self, clock: Clock, minutes: float) -> None:
        self._clock, self._minutes = clock, minutes
        self._used, self._start, self._told = 0.0, 0.0, False

    def on_train_start(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Begin to measure, unless an earlier session of the run has told.

        Raises:
            TrainingError: Reading and the first validation have used up the time of a run that begins.
        """
        self._used, self._start, self._told = self._clock.spent(), time.monotonic(), trainer.global_step > 0
        if not self._told and self._clock.left() == 0.0:
            raise TrainingError(
                f"reading and a first validation took {self._used:.0f} s, which leaves nothing of max_minutes "
                f"{self._minutes:.2g} to train in; resume the run, which finds the crops that were cut, or allow more"
            )

    def on_train_batch_start(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, *_: Any) -> None:
        """Tell once the pace is known, with all that comes between two steps."""
        measured = trainer.global_step >= _MEASURED_STEPS or self._clock.share_of_time() > _MEASURED_SHARE
        if trainer.global_step and measured:
            self._tell(trainer, pl_module)

    def on_train_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Tell what was over before its pace was known."""
        self._tell(trainer, pl_module)

    def _tell(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        assert isinstance(pl_module, PoseTraining)
        if self._told:
            return
        self._told = True
        pace = (time.monotonic() - self._start) / trainer.global_step
        validating = (pl_module.config.validations - 1) * pl_module.validation_seconds
        steps = trainer.global_step + int(max(0.0, self._clock.left() - validating) / pace)
        if steps >= min(LEAST_STEPS, self._clock.max_steps or LEAST_STEPS):
            return
        needed = self._used + validating + self._clock.reserved + LEAST_STEPS * pace
        log.warning(
            "about %d steps of %.2g s fit into max_minutes %.2g, of which reading and a first validation took %.0f s; "
            "fewer than %d hardly train anything: allow %.1f minutes or more",
            *(steps, pace, self._minutes, self._used, LEAST_STEPS, math.ceil(needed / 6.0) / 10.0),
        )
