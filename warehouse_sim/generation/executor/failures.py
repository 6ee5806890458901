"""What follows from a scene that fails or takes too long: it is tried once more, then named, or skipped on request."""

import logging
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from warehouse_sim.errors import ConfigError, MissingPackageError, OutputError, UnknownNameError, WorkerError


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise an error in the block when it takes longer.

    Only Python is interrupted, not a call into a library that never returns, and only in the main thread of a system
    with interval timers whose alarm nobody else uses; elsewhere there is no limit. Workers of their own are killed.

    Args:
        seconds: How long it may take; None = as long as it does.

    Raises:
        WorkerError: It took longer.
    """
    if seconds is None or not _is_free():
        yield
        return

    def expire(_: int, __: FrameType | None) -> None:
        raise WorkerError(too_long(seconds))

    signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)


def too_long(seconds: float) -> str:
    """Say that a limit was reached."""
    return f"its limit of {seconds:g} s for a scene (--scene-limit)"


def _is_free() -> bool:
    in_main = threading.current_thread() is threading.main_thread()
    return in_main and hasattr(signal, "setitimer") and signal.getsignal(signal.SIGALRM) == signal.SIG_DFL


Skip = Callable[[int, str], None]
"""Takes a scene that failed twice, and why."""

_TRIES = 2
"""What one scene may cost: the first death may be another program's doing."""
_MOST_LOST, _FRACTION_LOST = 3, 10
"""Scenes that are given up before machine or recipe are to blame and no other is begun; where they are skipped, that
many and one for every ten that are made."""
_NOT_OF_A_SCENE = (OutputError, MissingPackageError, ConfigError, UnknownNameError)
"""Errors that another scene would meet, too."""

_log = logging.getLogger(__name__)


class Failures:
    """The scenes of one run that failed.

    Args:
        seed: Seed of the dataset, for messages.
        skip: Called with each scene that failed twice; None = the run ends with an error.
    """

    def __init__(self, seed: int, skip: Skip | None = None) -> None:
        self._seed, self._skip = seed, skip
        self._tries: Counter[int] = Counter()
        self._lost: dict[int, str] = {}
        self._made = 0
        self.problem: Exception | None = None
        """The error that ends the run when the scenes at work are finished."""

    def made(self) -> None:
        """Take note of a scene that was made."""
        self._made += 1

    def died(self, scene_index: int, cause: str) -> bool:
        """Take note of a worker that was lost; return whether its scene is to be regenerated."""
        worker = f"the worker that made scene {scene_index} of seed {self._seed}"
        return self._again(scene_index, f"{worker} was ended by {cause}")

    def raised(self, scene_index: int, problem: Exception) -> bool:
        """Take note of what a scene raised; return whether it is to be regenerated."""
        last = self._tries[scene_index] + 1 >= _TRIES and self._skip is None
        if not last and not isinstance(problem, _NOT_OF_A_SCENE):
            return self._again(scene_index, f"scene {scene_index} of seed {self._seed} failed: {_one_line(problem)}")
        if not isinstance(problem, _NOT_OF_A_SCENE):
            problem.scenes = (scene_index,)  # type: ignore[attr-defined]
        self.problem = self.problem or problem
        return False

    @property
    def stop(self) -> bool:
        """Whether no other scene is to be begun."""
        allowed = _MOST_LOST + (0 if self._skip is None else self._made // _FRACTION_LOST)
        return self.problem is not None or len(self._lost) >= allowed

    def raise_them(self) -> None:
        """Raise what ends the run, if anything does."""
        if self.problem is not None:
            raise self.problem
        if self._lost and (self._skip is None or self.stop):
            error = WorkerError(
                f"{'; '.join(self._lost.values())}; all else is kept: free some memory, or make it alone with "
                "--workers 1 (and --resume, which goes on where this run stopped)"
            )
            error.scenes = tuple(self._lost)
            raise error

    def _again(self, scene_index: int, text: str) -> bool:
        self._tries[scene_index] += 1
        if self._tries[scene_index] < _TRIES:
            _log.warning("%s; the scene is regenerated", text)
            return True
        self._lost[scene_index] = f"{text}, {_TRIES} times"
        if self._skip is not None:
            _log.warning("%s; the scene is skipped", self._lost[scene_index])
            self._skip(scene_index, self._lost[scene_index])
        return False


def _one_line(problem: Exception) -> str:
    lines = str(problem).strip().splitlines()
    return lines[-1] if lines else type(problem).__name__
