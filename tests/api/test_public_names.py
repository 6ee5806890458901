"""The names of ``warehouse_sim``: few, light to import, each with an example that runs, seen by type checkers."""

import ast
import doctest
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import warehouse_sim as ws

NAMES = sorted(set(ws.__all__) - {"__version__"})
LONG = ("Writer", "stream")
"""Whose examples take longest; test_writer.py and test_stream.py do the same."""
HEAVY = ("torch", "mujoco", "moderngl", "OpenGL", "embreex", "matplotlib", "scipy.stats")


def test_there_are_few() -> None:
    assert len(NAMES) <= 21
    assert set(NAMES) == set(ws._PUBLIC)
    assert ws.__dir__() == sorted(ws.__all__)


def test_each_is_what_it_is_called() -> None:
    for name in NAMES:
        assert getattr(ws, name).__name__ == name
    with pytest.raises(AttributeError, match=r"no attribute 'nothing'$"):
        ws.nothing  # type: ignore[attr-defined]  # noqa: B018


def test_a_usual_guess_is_answered_with_the_name() -> None:
    assert set(ws._GUESSES.values()) <= set(NAMES)
    with pytest.raises(AttributeError, match=r"no attribute 'load'; use warehouse_sim.Dataset$"):
        ws.load  # type: ignore[attr-defined]  # noqa: B018


def test_importing_loads_nothing_heavy() -> None:
    code = f"import sys, warehouse_sim; print([m for m in {HEAVY} if m in sys.modules], 'numpy' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert run.stdout.split() == ["[]", "False"]


def test_type_checkers_import_what_is_imported_at_run_time() -> None:
    tree = ast.parse(Path(ws.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and isinstance(node.test, ast.Name))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    assert {alias.name: node.module for node in imports for alias in node.names} == ws._PUBLIC
    assert (Path(ws.__file__).parent / "py.typed").is_file()


@pytest.mark.gl
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in NAMES])
def test_the_example_of_each_runs(name: str, smoke: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "out").symlink_to(smoke)
    monkeypatch.chdir(tmp_path)
    found = doctest.DocTestFinder().find(getattr(ws, name), name, globs={"ws": ws, "np": np})
    examples = [test for test in found if test.examples]
    assert examples, f"{name} has no example in its docstring"
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    text: list[str] = []
    for test in examples:
        runner.run(test, out=text.append)
    assert not runner.failures, "".join(text)


USER = """
import warehouse_sim as ws

def count(data: ws.Dataset) -> int:
    return sum(len(obs.objects) for obs in data)

number: int = count(ws.Dataset("out"))
path: str = ws.report("out")
ws.nothing_of_that_name
"""


@pytest.mark.slow
def test_a_type_checker_sees_the_names(tmp_path: Path) -> None:
    (tmp_path / "user.py").write_text(USER + "\n".join(f"ws.{name}" for name in NAMES) + "\n", encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--ignore-missing-imports", "--follow-imports=silent", "user.py"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    errors = [line for line in run.stdout.splitlines() if ": error:" in line]
    assert [line.partition(": error: ")[2] for line in errors] == [
        'Incompatible types in assignment (expression has type "Path", variable has type "str")  [assignment]',
        'Module has no attribute "nothing_of_that_name"  [attr-defined]',
    ], run.stdout
