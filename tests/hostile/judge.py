"""What came of a case. Two verdicts are fine: a clear error, and a correct result; *raw* and *silent* are findings."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tests.hostile.case import Case, Outcome, name_of

_LONGEST_ERROR = 4000
"""Characters; a message that repeats a whole file is not clear. One that lists all names of the catalog still is."""
_TRACEBACK = "Traceback (most recent call last)"
_PLACE = re.compile(r'File "[^"]*?(warehouse_sim/[^"]+)", line (\d+), in (\S+)')
# What a Python programmer would say, and no user can act on.
_INTERNAL = re.compile(
    r"object has no attribute|is not subscriptable|not iterable|unsupported operand|index out of range"
    r"|must be real number|NoneType|KeyError|TypeError|IndexError|AttributeError|cannot reshape|broadcast|argument of"
)
_WARNING = re.compile(r"^.*(?:RuntimeWarning|WARNING: Nan).*$", re.MULTILINE)


@dataclass(frozen=True)
class Verdict:
    """The class of a case and why."""

    label: Literal["clear error", "correct", "raw", "silent"]
    reason: str = ""
    seconds: float = 0.0
    """Processor time of the case."""


def judge(case: Case, outcomes: Sequence[Outcome], folder: Path) -> Verdict:
    """Return the verdict on a case.

    Args:
        case: What was tried.
        outcomes: What its steps did, in turn, up to the first that did not succeed.
        folder: The case's folder, with what they wrote.
    """
    for outcome in outcomes:
        said = outcome.out + outcome.err
        if _TRACEBACK in said:
            places = _PLACE.findall(said)
            last = [line for line in said.strip().splitlines() if line and not line.startswith(" ")][-1]
            where = "{}:{} in {}".format(*places[-1]) if places else "outside of the package"
            return Verdict("raw", f"{outcome.name}: {where}: {last[:200]}")
        if outcome.code not in (0, 1, 2):
            return Verdict("raw", f"{outcome.name} left with exit code {outcome.code}")
    return _accepted(case, outcomes, folder) if outcomes[0].code == 0 else _rejected(case, outcomes[0])


def _accepted(case: Case, outcomes: Sequence[Outcome], folder: Path) -> Verdict:
    name = name_of(case.steps[0])
    # What reads a dataset may leave it to ``validate`` to say that the data are wrong.
    told = any(later.name == "validate" and later.code == 1 and "FAIL" in later.out for later in outcomes[1:])
    if case.expect == "reject" and not told:
        return Verdict("silent", f"{name} takes what nobody can mean: {case.mutation}")
    if unwell := _WARNING.search(outcomes[0].err):
        return Verdict("silent", f"{name} succeeds with a warning: {unwell.group()[:200]}")
    if case.check is not None and not told and (problem := case.check(folder, outcomes)):
        return Verdict("silent", f"{name} succeeds, but {problem}")
    return Verdict("correct")


def _rejected(case: Case, outcome: Outcome) -> Verdict:
    said = [line for line in (outcome.err + outcome.out).strip().splitlines() if line] or ["(nothing)"]
    message = next((line for line in said if re.search(r"^error: |FAIL|rejected", line)), said[-1])
    if problem := unclear(outcome, case.names):
        return Verdict("raw", f"{outcome.name}: {problem}")
    if case.expect == "accept":
        return Verdict("silent", f"{outcome.name} rejects what is right: {message[:300]}")
    return Verdict("clear error", message[:300])


def unclear(outcome: Outcome, names: Sequence[str]) -> str | None:
    """Return what keeps a rejection from being one clear line that names what is wrong, if anything."""
    shown = (outcome.err + outcome.out).strip()[-300:]
    if outcome.code == 1:
        said = any("FAIL " in line or "rejected:" in line for line in outcome.out.splitlines())
        return None if said else f"exit code 1 without a failed check: {shown!r}"
    lines = [line for line in outcome.err.splitlines() if line.startswith("error: ")]
    if len(lines) != 1:
        return f"{len(lines)} lines of error: {shown!r}"
    message = lines[0]
    if outcome.err.rstrip().splitlines()[-1] != message.rstrip():
        return f"the error is more than one line: {shown!r}"
    if len(message) > _LONGEST_ERROR:
        return f"the error is {len(message)} characters long"
    if _INTERNAL.search(message):
        return f"the error speaks Python: {message[:200]!r}"
    if names and not any(name.lower() in message.lower() for name in names if name):
        return f"the error names none of {', '.join(names[:4])}: {message[:200]!r}"
    return None
