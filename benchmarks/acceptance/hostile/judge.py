"""What came of a case, in one of six classes. Two are fine: a clear error, and a correct result."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from benchmarks.acceptance.hostile.case import Case
from benchmarks.acceptance.hostile.watch import Outcome

Class = Literal["clear error", "correct", "traceback", "crash", "hang", "silent nonsense"]
CLASSES: tuple[Class, ...] = ("clear error", "correct", "traceback", "crash", "hang", "silent nonsense")
FAULTS = CLASSES[2:]

_LONGEST_ERROR = 4000
"""Characters; a message that repeats a whole file is not clear. One that lists all names of the catalog still is."""
_TRACEBACK = "Traceback (most recent call last)"
_PLACE = re.compile(r'File "([^"]+)", line (\d+), in (\S+)')
# What a Python programmer would say, and no user can act on.
_INTERNAL = re.compile(
    r"object has no attribute|is not subscriptable|not iterable|unsupported operand|index out of range"
    r"|must be real number|NoneType|KeyError|TypeError|IndexError|AttributeError|cannot reshape|broadcast|argument of"
)
_WARNING = re.compile(r"^.*(?:RuntimeWarning|WARNING: Nan).*$", re.MULTILINE)


@dataclass(frozen=True)
class Verdict:
    """The class of a case and why."""

    label: Class
    reason: str
    cause: str = ""
    """Where in the code, or which rule: what cases of one cause share."""

    @property
    def is_fault(self) -> bool:
        """Whether this must not happen."""
        return self.label in FAULTS


def judge(case: Case, outcomes: Sequence[Outcome], folder: Path) -> Verdict:
    """Return the verdict on a case.

    Args:
        case: What was tried.
        outcomes: What its command lines did, in turn, up to the first that did not succeed.
        folder: The case's folder, with what they wrote.
    """
    for outcome in outcomes:
        broken = _broken(outcome)
        if broken:
            return broken
    first = outcomes[0]
    if first.code == 0:
        return _accepted(case, outcomes, folder)
    return _rejected(case, first)


def _broken(outcome: Outcome) -> Verdict | None:
    command = outcome.argv[0]
    if outcome.death == "hang":
        return Verdict("hang", f"{command} was still at work after {outcome.seconds:.0f} s", f"{command} never ends")
    if outcome.death:
        return Verdict("crash", f"{command} died: {outcome.death}", f"{command}: {outcome.death}")
    if _TRACEBACK in outcome.err + outcome.out:
        text = outcome.err + outcome.out
        places = [place for place in _PLACE.findall(text) if "warehouse_sim" in place[0]]
        file, line, function = places[-1] if places else ("?", "0", "?")
        file = file.partition("warehouse_sim/")[2] or file
        said = [row for row in text.strip().splitlines() if row and not row.startswith(" ")]
        return Verdict("traceback", f"{command}: {said[-1][:200]}", f"{file}:{line} in {function}: {_kind(said[-1])}")
    if outcome.code not in (0, 1, 2):
        return Verdict("crash", f"{command} left with exit code {outcome.code}", f"{command}: exit code {outcome.code}")
    return None


def _kind(line: str) -> str:
    return line.partition(":")[0][:80]


def _accepted(case: Case, outcomes: Sequence[Outcome], folder: Path) -> Verdict:
    if case.expect == "reject" and not _second_opinion(outcomes):
        return Verdict(
            "silent nonsense", f"{case.command} takes what nobody can mean", f"{case.command} takes {case.mutation}"
        )
    unwell = _WARNING.search(outcomes[0].err)
    if unwell:
        return Verdict(
            "silent nonsense", f"succeeds with a warning: {unwell.group()[:200]}", "a warning of numpy or MuJoCo"
        )
    problem = case.check(folder, outcomes)
    if problem:
        return Verdict(
            "silent nonsense", f"{case.command} succeeds, but {problem}", f"{case.command}: {_general(problem)}"
        )
    return Verdict("correct", "succeeds, and what came of it is sane")


def _second_opinion(outcomes: Sequence[Outcome]) -> bool:
    """Return whether a later ``validate`` says that the data are wrong."""
    return any(later.argv[0] == "validate" and later.code == 1 and "FAIL" in later.out for later in outcomes[1:])


def _general(problem: str) -> str:
    """Return a problem without its numbers, so that equal ones are counted together."""
    return re.sub(r"-?\d[\d.e+-]*", "N", problem)[:100]


def _rejected(case: Case, outcome: Outcome) -> Verdict:
    problem = unclear(outcome, case.names)
    if problem:
        return Verdict(
            "traceback", f"{case.command}: {problem}", f"unclear error of {case.command}: {_general(problem)}"
        )
    if case.expect == "accept":
        return Verdict(
            "silent nonsense",
            f"rejects what is right: {_message(outcome)[:300]}",
            f"{case.command} rejects {case.mutation}",
        )
    return Verdict("clear error", _message(outcome)[:300])


def unclear(outcome: Outcome, names: Sequence[str]) -> str | None:
    """Return what keeps a rejection from being one clear line that names what is wrong, if anything."""
    if outcome.code == 1:
        said = [
            line
            for line in outcome.out.splitlines()
            if line.startswith("FAIL") or "FAIL " in line or "rejected:" in line
        ]
        return None if said else f"exit code 1 without a failed check: {_message(outcome)[:200]!r}"
    lines = [line for line in outcome.err.splitlines() if line.startswith("error: ")]
    if not lines and _is_usage(outcome):
        return None
    if len(lines) != 1:
        return f"{len(lines)} lines of error: {_message(outcome)[:200]!r}"
    message = lines[0]
    if outcome.err.rstrip().splitlines()[-1] != message:
        return f"the error is more than one line: {_message(outcome)[:200]!r}"
    if len(message) > _LONGEST_ERROR:
        return f"the error is {len(message)} characters long"
    if _INTERNAL.search(message):
        return f"the error speaks Python: {message[:200]!r}"
    if names and not any(name.lower() in message.lower() for name in names if name):
        return f"the error names none of {', '.join(names[:4])}: {message[:200]!r}"
    return None


def _is_usage(outcome: Outcome) -> bool:
    """Return whether the command line's parser explains, in a frame, what it cannot take."""
    return "╭─" in outcome.out + outcome.err


def _message(outcome: Outcome) -> str:
    said = [line for line in outcome.err.splitlines() if line.startswith("error: ")]
    failed = [line for line in outcome.out.splitlines() if "FAIL" in line or "rejected" in line]
    return (said or failed or (outcome.err + outcome.out).strip().splitlines() or ["(nothing)"])[-1]
