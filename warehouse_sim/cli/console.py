"""How commands speak: results to stdout, progress to stderr, and at the end what comes next."""

import shlex
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from warehouse_sim.errors import InputError

FractionProgress = Callable[[float, str], None]
"""Takes the fraction that is done (0-1) and a note on what is going on."""
CountProgress = Callable[[int, int], None]
"""Takes how many are done and how many there are."""

_chatter = Console(stderr=True, highlight=False)


def say(message: str) -> None:
    """Write a line of chatter to stderr."""
    _chatter.print(message, markup=False, soft_wrap=True)


def finish(output: Path, *next_command: str | Path) -> None:
    """Print where the output is and which command comes next."""
    print(f"output: {output}")
    if next_command:
        print(f"next:   {shlex.join(['warehouse-sim', *map(str, next_command)])}")


def require_ending(option: str, file: Path, *endings: str) -> None:
    """Reject a file whose name says that something else is in it; a name without an ending says nothing.

    Raises:
        InputError: Names the endings.
    """
    if file.suffix.lower() not in ("", *endings):
        raise InputError(f"{option} {file}: is written as {' or '.join(endings)}; give it a name that ends so")


@contextmanager
def fraction_progress(label: str) -> Iterator[FractionProgress]:
    """Yield a callback ``(fraction, note)``: a bar on a terminal, a line at each tenth otherwise."""
    if not _chatter.is_terminal:
        yield _line_every_tenth(label)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, TextColumn("{task.fields[note]}"), console=_chatter) as bar:
        task = bar.add_task(label, total=1.0, note="")
        yield lambda fraction, note: bar.update(task, completed=fraction, note=note)


@contextmanager
def count_progress(label: str) -> Iterator[CountProgress]:
    """Yield a callback ``(done, total)``, shown as ``fraction_progress`` shows it, with rate and time that is left."""
    pace = _Pace()
    with fraction_progress(label) as update:
        yield lambda done, total: update(done / max(total, 1), pace.note(done, total))


class _Pace:
    """How fast things are made in this run; what was there before it is not counted."""

    def __init__(self) -> None:
        self._start: tuple[int, float] | None = None

    def note(self, done: int, total: int) -> str:
        """Return how many are done and, from the second call on, how many a minute and how long the rest takes."""
        now, counted = time.monotonic(), f"{done}/{total}"
        if self._start is None:
            self._start = done, now
        made, seconds = done - self._start[0], now - self._start[1]
        if made <= 0 or seconds <= 0:
            return counted
        left = "" if done >= total else f", {_duration((total - done) * seconds / made)} left"
        rate = 60 * made / seconds
        return f"{counted}, {rate:{',.0f' if rate >= 100 else '.3g'}} a minute{left}"


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def _line_every_tenth(label: str) -> FractionProgress:
    start, last = time.monotonic(), [-1]

    def update(fraction: float, note: str) -> None:
        tenth = int(10 * fraction)
        if tenth > last[0]:
            last[0] = tenth
            print(f"{label}: {fraction:.0%}, {time.monotonic() - start:.0f} s, {note}", file=sys.stderr, flush=True)

    return update
