"""How verbs speak: results to stdout, progress to stderr, and at the end what comes next."""

import shlex
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

ShareProgress = Callable[[float, str], None]
"""Takes the share that is done (0-1) and a note on what is going on."""
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


@contextmanager
def share_progress(label: str) -> Iterator[ShareProgress]:
    """Yield a callback ``(share, note)``: a bar on a terminal, a line at each tenth otherwise."""
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
        yield lambda share, note: bar.update(task, completed=share, note=note)


@contextmanager
def count_progress(label: str) -> Iterator[CountProgress]:
    """Yield a callback ``(done, total)``, shown as ``share_progress`` shows it."""
    with share_progress(label) as update:
        yield lambda done, total: update(done / max(total, 1), f"{done}/{total}")


def _line_every_tenth(label: str) -> ShareProgress:
    start, last = time.monotonic(), [-1]

    def update(share: float, note: str) -> None:
        tenth = int(10 * share)
        if tenth > last[0]:
            last[0] = tenth
            print(f"{label}: {share:.0%}, {time.monotonic() - start:.0f} s, {note}", file=sys.stderr, flush=True)

    return update
