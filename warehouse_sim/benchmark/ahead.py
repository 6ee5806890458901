"""Train, predict and score side by side, before a suite is gone through in order and finds what was kept."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Protocol

from warehouse_sim.benchmark.entrants.entrant import Entrant
from warehouse_sim.benchmark.scored import Opened, is_scored, scored
from warehouse_sim.benchmark.sets import MadeSet
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import WarehouseSimError, WorkerError
from warehouse_sim.generation.executor import Work, make_scenes

OnTask = Callable[[int, int], None]


class Task(Protocol):
    """Something that is kept once it is made; can be pickled."""

    @property
    def is_made(self) -> bool:
        """Whether it was made before."""

    def make(self) -> object:
        """Make it."""


@dataclass(frozen=True)
class Question:
    """One entrant under one condition."""

    member: Entrant
    condition: ConditionConfig
    data: MadeSet
    split: str
    out: Path
    """Folder of the benchmark."""
    overwrite: bool = False
    """Predict and score again, whatever is kept."""

    @property
    def is_made(self) -> bool:
        """Whether its answer was scored before."""
        return not self.overwrite and is_scored(self.member, self.condition, self._opened, self.out)

    def make(self) -> object:
        """Predict and score; what is kept is used."""
        return scored(self.member, self.condition, self._opened, self.out, self.overwrite)

    @property
    def _opened(self) -> Opened:
        return Opened(self.data, _reader(self.data.root), {}, self.split)


def make_ahead(tasks: Sequence[Task], workers: int, report: OnTask = lambda done, total: None) -> set[int]:
    """Make what is not made yet, each task by one of several processes with a processor each, and return which were.

    What cannot be made is left to whoever requires it next, who then names the reason.

    Args:
        tasks: What is wanted.
        workers: Processes; with 1, or where less than two tasks are left, nothing is made ahead.
        report: Called with the tasks that are done and with how many there are.

    Returns:
        Numbers of the tasks that were made now.
    """
    if workers < 2:
        return set()
    left = [number for number, task in enumerate(tasks) if not _is_made(task)]
    if len(left) < 2:
        return set()
    made, done = set[int](), 0
    with suppress(WorkerError):  # Its message speaks of scenes.
        for number, is_made in make_scenes(partial(_open, tuple(tasks)), 0, left, workers):
            done += 1
            report(done, len(left))
            if is_made:
                made.add(number)
    return made


@contextmanager
def _open(tasks: Sequence[Task]) -> Iterator[Work]:
    def make(number: int) -> bool:
        try:
            tasks[number].make()
        except Exception:  # Whoever asks next meets it in order, and tells it whole.
            return False
        return True

    yield make


def _is_made(task: Task) -> bool:
    try:
        return task.is_made
    except WarehouseSimError:
        return True  # It cannot be made either.


@lru_cache(maxsize=4)
def _reader(root: Path) -> DatasetReader:
    return DatasetReader(root)
