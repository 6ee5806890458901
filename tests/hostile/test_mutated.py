"""Thousands of mutated inputs: none ends in a raw error, and nothing that must be wrong is accepted in silence.

Each is a file, a command line or a Python call that is right but for one mutation, tried as a user would, in a worker
process. A finding is *raw* where it ends in a traceback, a crash, a hang, another exit code than 2, or an error that
names neither the file nor the key; and *silent* where what nobody can mean is accepted, or what comes of it is wrong.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import pytest

from tests.hostile.case import Case, Expectation
from tests.hostile.judge import Verdict
from tests.hostile.pick import pick
from tests.hostile.stock import make_stock
from tests.hostile.worker import try_cases

SEED = 0


def findings(cases: Sequence[Case], verdicts: Sequence[Verdict]) -> list[str]:
    return [
        f"{verdict.label}: {verdict.reason}\n    python -m tests.hostile '{case.id}'"
        for case, verdict in zip(cases, verdicts, strict=True)
        if verdict.label in ("raw", "silent")
    ]


@pytest.mark.slow
@pytest.mark.gl
def test_five_thousand_mutated_inputs(tmp_path: Path) -> None:
    cases = pick(make_stock(tmp_path / "stock", whole=True), 5000, SEED)
    assert len(cases) >= 5000
    assert sum(case.kind.startswith("call") for case in cases) >= 1000
    found = findings(cases, try_cases(cases, 2, tmp_path))
    assert not found, "\n".join([f"{len(found)} findings", *found])


@pytest.mark.gl
def test_a_dozen_mutated_inputs(tmp_path: Path) -> None:
    cases = pick(make_stock(tmp_path / "stock", whole=False), 12, SEED)
    found = findings(cases, try_cases(cases, 1, tmp_path))
    assert not found, "\n".join([f"{len(found)} findings", *found])


FINE = 'print("output: x")'
RAISE = "import warehouse_sim as ws; raise ws.WarehouseSimError"
CLEAR = f"""{RAISE}("a.yaml: widht is not a setting; did you mean 'width'?")"""
PLANTED: list[tuple[str, str, Expectation, str]] = [
    ("fine", FINE, "either", "correct"),
    ("clear", CLEAR, "reject", "clear error"),
    ("what nobody can mean", FINE, "reject", "silent"),
    ("what is right", CLEAR, "accept", "silent"),
    ("a warning", "import numpy; numpy.float64(1) / 0", "either", "silent"),
    ("vague", f'{RAISE}("something is wrong")', "reject", "raw"),
    ("two lines", rf'{RAISE}("a.yaml: this\nand that")', "reject", "raw"),
    ("Python", f'{RAISE}("a.yaml: KeyError")', "reject", "raw"),
    ("a traceback", "{}['widht']", "reject", "raw"),
    ("an exit", "raise SystemExit(7)", "reject", "raw"),
    ("a segmentation fault", "import ctypes; ctypes.string_at(0)", "reject", "raw"),
    ("an exit from within", "import os; os._exit(2)", "reject", "raw"),
]


def test_the_judge_finds_what_is_planted(tmp_path: Path) -> None:
    cases = [
        Case("planted", "code", name, (partial(exec, code),), expect=expect, names=("a.yaml",))
        for name, code, expect, _ in PLANTED
    ]
    found = {case.mutation: verdict.label for case, verdict in zip(cases, try_cases(cases, 1, tmp_path), strict=True)}
    assert found == {name: label for name, _, _, label in PLANTED}
