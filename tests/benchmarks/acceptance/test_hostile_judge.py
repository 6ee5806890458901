"""The judge of hostile input catches what is planted, on a command that is none of ours."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.acceptance.hostile.case import Case
from benchmarks.acceptance.hostile.run import try_case, try_cases
from benchmarks.acceptance.hostile.table import as_json, count_table, fault_lines
from benchmarks.acceptance.hostile.watch import Limits, Watched

COMMAND = """
import ctypes, os, signal, subprocess, sys, time

def main(argv):
    say = lambda text: print(text, file=sys.stderr)
    match argv[0]:
        case "fine":
            print("output: x")
            return 0
        case "clear":
            say("reading mutant.yaml")
            say("error: mutant.yaml: widht is not a setting; did you mean 'width'?")
            return 2
        case "vague":
            say("error: something is wrong")
            return 2
        case "two errors":
            say("error: mutant.yaml: this")
            say("error: mutant.yaml: that")
            return 2
        case "two lines":
            say("error: mutant.yaml: this\\nand that")
            return 2
        case "python":
            say("error: mutant.yaml: 'NoneType' object has no attribute 'width'")
            return 2
        case "endless":
            say("error: mutant.yaml: " + "9" * 5001)
            return 2
        case "mute":
            return 2
        case "traceback":
            raise KeyError("widht")
        case "printed traceback":
            subprocess.run([sys.executable, "-c", "1 / 0"])
            return 0
        case "exit 7":
            sys.exit(7)
        case "leaves":
            os._exit(2)
        case "segfault":
            ctypes.string_at(0)
        case "division":
            os.kill(os.getpid(), signal.SIGFPE)
        case "abort":
            os.abort()
        case "sleeps":
            time.sleep(60)
        case "loops":
            while True:
                pass
        case "grows":
            kept = []
            while True:
                kept.append(bytearray(b"x" * (1 << 24)))
        case "warns":
            say("numpy.py:3: RuntimeWarning: invalid value encountered in divide")
            return 0
        case "FAIL":
            print("FAIL  bop tables: scene_gt.json: obj_id is 99")
            return 1
        case "fails mutely":
            return 1
"""


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Watched]:
    folder = tmp_path_factory.mktemp("command")
    (folder / "planted_command.py").write_text(COMMAND, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(folder))
        with Watched("planted_command:main", Limits(seconds=60.0, memory=0.5), folder / "scratch") as worker:
            yield worker


@pytest.fixture
def hurried(watched: Watched, tmp_path: Path) -> Iterator[Watched]:
    """A worker for the same command that gives up after a second: only for what never ends, on any machine."""
    with Watched("planted_command:main", Limits(seconds=1.0, memory=0.5), tmp_path / "scratch") as worker:
        yield worker


def case(words: str, **settings: object) -> Case:
    return Case("recipe", "x", "planted", ((words,),), lambda folder: None, names=("mutant.yaml",), **settings)


@pytest.mark.parametrize(
    ("words", "label"),
    [
        ("fine", "correct"),
        ("clear", "clear error"),
        ("FAIL", "clear error"),
        ("vague", "traceback"),
        ("two errors", "traceback"),
        ("two lines", "traceback"),
        ("python", "traceback"),
        ("endless", "traceback"),
        ("mute", "traceback"),
        ("fails mutely", "traceback"),
        ("traceback", "traceback"),
        ("printed traceback", "traceback"),
        ("exit 7", "crash"),
        ("leaves", "crash"),
        ("segfault", "crash"),
        ("division", "crash"),
        ("abort", "crash"),
        ("grows", "crash"),
        ("warns", "silent nonsense"),
    ],
)
def test_what_is_planted_is_found(watched: Watched, tmp_path: Path, words: str, label: str) -> None:
    result = try_case(case(words), watched, tmp_path / "case")
    assert result.verdict.label == label, result.verdict
    assert not (tmp_path / "case").exists()


@pytest.mark.parametrize("words", ["sleeps", pytest.param("loops", marks=pytest.mark.slow)])
def test_what_never_ends_hangs(hurried: Watched, tmp_path: Path, words: str) -> None:
    assert try_case(case(words), hurried, tmp_path / "case").verdict.label == "hang"
    assert not (tmp_path / "case").exists()


def test_success_on_what_nobody_can_mean_is_nonsense(watched: Watched, tmp_path: Path) -> None:
    assert try_case(case("fine", expect="reject"), watched, tmp_path / "case").verdict.label == "silent nonsense"
    assert try_case(case("clear", expect="reject"), watched, tmp_path / "case").verdict.label == "clear error"


def test_rejecting_what_is_right_is_a_fault(watched: Watched, tmp_path: Path) -> None:
    assert try_case(case("clear", expect="accept"), watched, tmp_path / "case").verdict.is_fault


def test_a_success_is_looked_at(watched: Watched, tmp_path: Path) -> None:
    wrong = case("fine", check=lambda folder, outcomes: "the camera is in the wall")
    verdict = try_case(wrong, watched, tmp_path / "case").verdict
    assert verdict.label == "silent nonsense"
    assert "the camera is in the wall" in verdict.reason


def test_a_later_step_that_dies_counts(watched: Watched, tmp_path: Path) -> None:
    steps = Case("dataset", "x", "planted", (("fine",), ("abort",)), lambda folder: None)
    assert try_case(steps, watched, tmp_path / "case").verdict.label == "crash"


def test_a_new_worker_follows_one_that_died(watched: Watched, tmp_path: Path) -> None:
    for words, label in (("segfault", "crash"), ("fine", "correct"), ("abort", "crash"), ("clear", "clear error")):
        assert try_case(case(words), watched, tmp_path / "case").verdict.label == label


def test_a_new_worker_follows_one_that_was_stopped(hurried: Watched, tmp_path: Path) -> None:
    for words, label in (("loops", "hang"), ("fine", "correct")):
        assert try_case(case(words), hurried, tmp_path / "case").verdict.label == label


def test_the_table_counts_each_case_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "planted_command.py").write_text(COMMAND, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    cases = [case(words) for words in ("fine", "clear", "traceback", "abort", "loops", "warns")]
    results = try_cases(cases, 2, Limits(seconds=2.0), command="planted_command:main")
    labels = ["correct", "clear error", "traceback", "crash", "hang", "silent nonsense"]
    assert [result.verdict.label for result in results] == labels
    result = as_json(results, seed=0, cases=6, machine={"cores": 2}, seconds=2.0)
    assert result["rows"][0] == {"name": "all", "value": 4, **{label.replace(" ", "_"): 1 for label in labels}}
    assert len(result["faults"]) == 4
    assert all("--only" in fault["replay"] for fault in result["faults"])
    assert len([line for line in fault_lines(results) if not line.startswith(" ")]) == 4
    assert count_table(results).row_count == 7
