"""What a check is and what it has found."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from warehouse_sim.dataset.files.extent import read_bytes
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema.outputs import Output, in_words


def read_text(path: Path) -> str:
    """Read an ASCII file.

    Raises:
        DatasetError: It cannot be read, or holds something else.
    """
    try:
        return read_bytes(path).decode("ascii")
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{path}: holds something else than ASCII text ({problem.reason})") from problem


_KEPT = 100
"""Problems that a check keeps: a folder can hold more wrong files than memory."""


@dataclass(frozen=True)
class Check:
    """The outcome of one check."""

    name: str
    ok: bool
    detail: str
    """What was examined, or the first thing that is wrong."""
    checked: bool = True
    """False where the dataset does not hold what the check looks at; ``detail`` then says what that is."""


@dataclass
class Findings:
    """Collects what is wrong while a check runs."""

    examined: str = ""
    """What was looked at, with its number."""
    problems: list[str] = field(default_factory=list)
    """The first ones that are wrong."""
    more: int = 0
    """How many were found beyond them."""
    count: int = 0
    """Number of what was looked at, where parts of a check are put together."""
    lacking: str = ""
    """What the dataset does not hold, so that nothing could be looked at."""

    def require(self, holds: bool, problem: str) -> bool:
        """Note ``problem`` unless ``holds``; return ``holds``."""
        if not holds and len(self.problems) < _KEPT:
            self.problems.append(problem)
        elif not holds:
            self.more += 1
        return holds

    def outcome(self, name: str) -> Check:
        """Return them as the outcome of the check ``name``."""
        if not self.problems and self.lacking:
            return Check(name, True, f"not checked: {self.lacking}", checked=False)
        if not self.problems:
            return Check(name, True, self.examined)
        others = len(self.problems) - 1 + self.more
        return Check(name, False, self.problems[0] + (f" (and {others} more)" if others else ""))

    def add(self, part: "Findings") -> None:
        """Take over what a part of the check has found."""
        for problem in part.problems:
            self.require(False, problem)
        self.more += part.more
        self.count += part.count


@dataclass(frozen=True)
class NamedCheck:
    """A check as it is requested."""

    name: str
    """As ``validate`` prints it."""
    run: Callable[..., Findings]
    """Takes the ``Subject``."""
    compares_with: str | None = None
    """Another format that the dataset must hold, too."""
    needs: tuple[tuple[Output, ...], ...] = ()
    """Sets of outputs with which it can be made, one of which the dataset must hold; none = it always can."""

    def lacks(self, outputs: frozenset[Output]) -> str:
        """Return the outputs that the nearest set lacks of these, in words; empty if one of the sets is there."""
        return min((in_words(set(needed) - outputs) for needed in self.needs), key=len, default="")


def compare_names(findings: Findings, folder: Path, expected: set[str], kind: str = "file") -> None:
    """Note which ``expected`` names are missing in ``folder`` and which are there beyond them."""
    found = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    for words, names in (("is missing", expected - found), ("does not belong to the dataset", found - expected)):
        for name in sorted(names):
            findings.require(False, f"{folder / name}: this {kind} {words}")
