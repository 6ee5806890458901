"""What work costs: CPU-seconds of a process with all its threads, and seconds on the wall."""

import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Cost:
    """Time that something took."""

    cpu_s: float
    """CPU time of the process and all its threads (s); a busy machine changes it little."""
    wall_s: float
    """Time that passed (s)."""


def measure(work: Callable[..., Result], *arguments: Any, **keywords: Any) -> tuple[Cost, Result]:
    """Call ``work`` and return what it cost and its result."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = work(*arguments, **keywords)
    return Cost(time.process_time() - cpu, time.perf_counter() - wall), result


def median(costs: Sequence[Cost]) -> Cost:
    """Return the medians of both times."""
    return Cost(statistics.median(cost.cpu_s for cost in costs), statistics.median(cost.wall_s for cost in costs))


class StageClock:
    """Sums time by stage; a nested stage is taken out of the one around it.

    Args:
        now: The clock that is read (s).
    """

    def __init__(self, now: Callable[[], float] = time.process_time) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._now = now
        self._inner = [0.0]

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the block under ``name``."""
        start = self._now()
        self._inner.append(0.0)
        try:
            yield
        finally:
            elapsed = self._now() - start
            self.seconds[name] += elapsed - self._inner.pop()
            self._inner[-1] += elapsed

    @contextmanager
    def watching(self, functions: Sequence[tuple[Any, str, str]]) -> Iterator[None]:
        """Count every call of some functions while the block runs.

        Args:
            functions: Module, object or class that holds the function; the function's name there; the stage.
        """
        held = [(owner, name, name in vars(owner), getattr(owner, name)) for owner, name, _ in functions]
        for (owner, name, stage), (_, _, _, function) in zip(functions, held, strict=True):
            setattr(owner, name, self._counted(function, stage))
        try:
            yield
        finally:
            for owner, name, own, function in held:
                if own:
                    setattr(owner, name, function)
                else:
                    delattr(owner, name)  # an object found it in its class, and does so again

    def _counted(self, function: Callable[..., Result], stage: str) -> Callable[..., Result]:
        def counted(*arguments: Any, **keywords: Any) -> Result:
            with self.stage(stage):
                return function(*arguments, **keywords)

        return counted
