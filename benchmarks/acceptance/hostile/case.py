"""A hostile case: what is written, which command lines read it, and what may come of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from benchmarks.acceptance.hostile.watch import Outcome

Expectation = Literal["reject", "either", "accept"]
"""Must be rejected; may be taken if what comes of it is sane; must be taken."""
Check = Callable[[Path, Sequence[Outcome]], str | None]
"""Takes the case's folder and the outcomes; says what is wrong with what came of it, if anything."""


def nothing_to_check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    """Find no fault: the exit code says all."""
    return None


@dataclass(frozen=True)
class Case:
    """One mutation and the command lines that meet it."""

    kind: str
    """Kind of file that is mutated: recipe, rig, object, dataset, predictions, run, command line."""
    what: str
    """File and place in it."""
    mutation: str
    """Name of the mutation."""
    steps: tuple[tuple[str, ...], ...]
    """Command lines, run in turn while they succeed; ``{folder}`` is the case's folder. The first one is judged, the
    others show what comes of it."""
    write: Callable[[Path], None]
    """Writes what is hostile into the case's folder."""
    expect: Expectation = "either"
    check: Check = nothing_to_check
    names: tuple[str, ...] = ()
    """Words of which a rejection must hold one: the file, the key, the value."""

    @property
    def id(self) -> str:
        """One word that ``--only`` takes."""
        return "/".join([self.kind, self.what, self.mutation, self.command]).replace(" ", "_")

    @property
    def command(self) -> str:
        """The command that is judged."""
        return self.steps[0][0]
