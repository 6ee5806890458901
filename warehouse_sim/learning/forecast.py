"""Forecast at the beginning of a training how many steps fit into its time."""

import logging
import math
import time

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.observer import Observer, TrainingState

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
