"""How far a training run is: by steps, by wall time, or whichever ends first; survives a resume."""

import math
import time


class Clock:
    """Measure progress from 0 to 1; starts when it is made.

    Args:
        max_steps: Optimiser steps of the whole run, or None.
        max_seconds: Wall time of the whole run, preparation and earlier sessions included, or None.
    """

    def __init__(self, max_steps: int | None, max_seconds: float | None) -> None:
        self.max_steps, self.max_seconds = max_steps, max_seconds
        self._start = time.monotonic()
        self._training_start: float | None = None
        self._spent_before, self._trained_before = 0.0, 0.0
        self.reserved = 0.0
        """Seconds that are kept for what follows the last step."""
        self._agreed: float | None = None

    def start_training(self) -> None:
        """Mark the end of the preparation: from here on the learning rate falls."""
        self._training_start = time.monotonic()

    def spent(self) -> float:
        """Return the seconds since the run began, without pauses between sessions."""
        return self._spent_before + time.monotonic() - self._start

    def trained(self) -> float:
        """Return the seconds of training without preparation."""
        return self._trained_before + (time.monotonic() - self._training_start if self._training_start else 0.0)

    def state(self) -> dict[str, float]:
        """Return what a later session must know."""
        return {"spent": self.spent(), "trained": self.trained()}

    def continue_from(self, state: dict[str, float]) -> None:
        """Count the time of earlier sessions, as ``state`` returned it."""
        self._spent_before, self._trained_before = state["spent"], state["trained"]

    def reserve(self, seconds: float) -> None:
        """Keep ``seconds`` of the wall time for what follows the last step."""
        self.reserved = seconds

    def left(self) -> float:
        """Return the seconds that are left for training, >= 0; infinity without a limit."""
        return math.inf if self.max_seconds is None else max(0.0, self.max_seconds - self.reserved - self.spent())

    def fraction_of_time(self) -> float:
        """Return the fraction of the training that is over by the wall time, 0-1; 0 without a limit."""
        if self.max_seconds is None:
            return 0.0
        left = self.left()
        return min(1.0, self.trained() / (self.trained() + left)) if left else 1.0

    def agree(self, fraction_of_time: float) -> None:
        """Go by this fraction of the time from now on, instead of the own one."""
        self._agreed = fraction_of_time

    def fraction(self, step: int) -> float:
        """Return the fraction of the training that is over after ``step`` steps, 0-1."""
        by_steps = step / self.max_steps if self.max_steps else 0.0
        return min(1.0, max(by_steps, self.fraction_of_time() if self._agreed is None else self._agreed))


def learning_rate_factor(fraction: float, step: int, warmup_steps: int, floor: float = 0.01) -> float:
    """Return the factor on the learning rate: linear over the first steps, then half a cosine down to ``floor``.

    Args:
        fraction: Fraction of the run that is over, 0-1.
        step: Steps done.
        warmup_steps: Length of the linear part, which ends after a tenth of the run at the latest.
        floor: Factor at the end.
    """
    warm = min(1.0, max((step + 1) / max(1, warmup_steps), 10.0 * fraction))
    return warm * (floor + (1.0 - floor) * 0.5 * (1.0 + math.cos(math.pi * fraction)))
