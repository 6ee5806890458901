"""A hostile case: what is written, what reads it, and what may come of it."""

import hashlib
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar

T = TypeVar("T")
Expectation = Literal["reject", "either", "accept"]
"""Must be rejected; may be taken if what comes of it is sane; must be taken."""
Step = tuple[str, ...] | Callable[[], Any]
"""A command line without the program's name, or a call; both run in the case's folder."""


@dataclass(frozen=True)
class Outcome:
    """What a step did: its exit code (2 where a call raises an error of the family), streams, and what it returned."""

    name: str
    code: int
    out: str = ""
    err: str = ""
    value: Any = None


Check = Callable[[Path, Sequence[Outcome]], str | None]
"""Takes the case's folder and the outcomes; says what is wrong with what came of it, if anything."""


@dataclass(frozen=True)
class Case:
    """One mutation and the steps that meet it; all of it crosses to another process."""

    kind: str
    """Kind of input that is mutated; those of Python calls begin with "call"."""
    what: str
    """File and place in it, or function and argument."""
    mutation: str
    steps: tuple[Step, ...]
    """Run in turn while they succeed. The first one is judged, the others show what comes of it."""
    write: Callable[[Path], Any] | None = None
    """Writes what is hostile into the case's folder."""
    expect: Expectation = "either"
    check: Check | None = None
    names: tuple[str, ...] = ()
    """Words of which a rejection must hold one: the file, the key, the value."""

    @property
    def id(self) -> str:
        """One word that ``python -m tests.hostile`` takes."""
        return "/".join([self.kind, self.what, self.mutation, name_of(self.steps[0])]).replace(" ", "_")


def name_of(step: Step) -> str:
    """Return the command, or the name of the function that is called."""
    return step[0] if isinstance(step, tuple) else getattr(step, "func", step).__name__


def stream(*words: object) -> random.Random:
    """Return a random stream that depends on words alone: a case is the same whatever others there are."""
    return random.Random(int.from_bytes(hashlib.sha256("/".join(map(str, words)).encode()).digest()[:8], "big"))


def one_of(options: Sequence[T], *words: object) -> T:
    return stream(*words).choice(options)
