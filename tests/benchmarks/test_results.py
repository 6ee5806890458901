"""Committed results have one shape: machine, command, named rows of numbers; and each command is there."""

import inspect
import json
import re
import shlex
from functools import wraps
from pathlib import Path
from typing import Any

import pytest

from warehouse_sim.benchmark.report import write_suite_report
from warehouse_sim.benchmark.result import read_result
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.cli.arguments import call
from warehouse_sim.cli.commands import COMMANDS
from warehouse_sim.errors import WarehouseSimError

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "benchmarks" / "results"
RESULTS = sorted(FOLDER.glob("*.json"))
SPEED_ROWS = {
    "rgbd_ids_vs_pyrender",
    "rgbd_ids_vs_mujoco",
    "full_observation",
    "encoding",
    "memory",
    "scaling",
}


SUITES = sorted((FOLDER / "suites").glob("*.json"))


@pytest.mark.parametrize("path", SUITES, ids=lambda path: path.stem)
def test_a_result_of_a_suite_is_one_of_the_suite_as_it_is(path: Path) -> None:
    result = read_result(path)
    suite = load_suite(result.suite.rpartition("-v")[0])
    assert result.suite == suite.title, "made with another version of the suite"
    assert not result.quick
    assert result.command.startswith("warehouse-sim bench ")
    # Where nothing but negatives and approaches is evaluated, there is nothing to shuffle.
    ends = {"oracle", "shuffled"} & {"oracle", *suite.estimators}
    assert ends <= {row.estimator for row in result.rows}


def test_the_leaderboards_of_the_documents_are_those_of_the_results(tmp_path: Path) -> None:
    document = FOLDER.parents[1] / "docs" / "leaderboards.md"
    written = write_suite_report((FOLDER / "suites",), tmp_path / "leaderboards.md")
    renew = "warehouse-sim report benchmarks/results/suites --out docs/leaderboards.md"
    assert document.read_text(encoding="utf-8") == written.read_text(encoding="utf-8"), renew


def fault(command: str) -> str:
    """Return what keeps a command from running in this repository; nothing is run."""
    words = shlex.split(command)
    while "=" in words[0]:  # variables of the environment
        words.pop(0)
    match words:
        case ["python", "-m", "pytest", *rest]:
            paths = [word for word in rest if word.startswith("tests/")]
            return "" if paths and all((ROOT / path).exists() for path in paths) else "no such tests"
        case ["python", "-m", name, *_]:
            place = ROOT / name.replace(".", "/")
            there = place.with_suffix(".py").is_file() or (place / "__main__.py").is_file()
            return "" if there else f"no module {name}"
        case ["make", target]:
            rules = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
            return "" if target in rules else f"no target {target}"
        case ["warehouse-sim", name, *rest] if name in COMMANDS:
            return fault_of_arguments(name, rest)
    return "no command of this repository"


def fault_of_arguments(name: str, words: list[str]) -> str:
    """Return what is wrong with the arguments of a command of ``warehouse-sim``, the name of its suite included."""
    function, taken = COMMANDS[name].function(), dict[str, Any]()

    @wraps(function)
    def take(*positional: Any, **named: Any) -> None:
        taken.update(inspect.signature(function).bind(*positional, **named).arguments)

    try:
        call(COMMANDS[name], take, words)
        if name == "bench":
            load_suite(taken["suite"])
    except WarehouseSimError as problem:
        return str(problem)
    return ""


@pytest.mark.parametrize("path", [*RESULTS, *SUITES], ids=lambda path: path.stem)
def test_the_command_of_a_result_is_there(path: Path) -> None:
    assert fault(json.loads(path.read_text(encoding="utf-8"))["command"]) == ""


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("python -m benchmarks.acceptance.film --write", "no module benchmarks.acceptance.film"),
        ("OMP_NUM_THREADS=1 python -m benchmarks.sped", "no module benchmarks.sped"),
        ("python -m benchmarks.front_ends", "no module benchmarks.front_ends"),
        ("python -m pytest -m slow tests/gone.py", "no such tests"),
        ("python -m pytest", "no such tests"),
        ("make gone", "no target gone"),
        ("make speed in clean clones", "no command"),
        ("warehouse-sim bnch docking", "no command"),
        ("warehouse-sim bench gone", "gone"),
        ("warehouse-sim bench docking --gone", "--gone"),
    ],
)
def test_a_command_that_is_gone_is_told(command: str, problem: str) -> None:
    assert problem in fault(command)


def test_there_are_results() -> None:
    assert RESULTS


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_a_result_says_how_it_was_measured(path: Path) -> None:
    result = json.loads(path.read_text())
    assert result["machine"]
    assert result["command"]
    names = [row["name"] for row in result["rows"]]
    assert len(names) == len(set(names)) > 0
    for row in result["rows"]:
        numbers = [value for key, value in row.items() if key in ("value", "ours_cpu_s")]
        assert numbers
        assert all(value >= 0 for value in numbers)
        if "interval" in row:
            low, high = row["interval"]
            assert low <= row["value"] <= high


def speed_rows() -> dict[str, dict]:
    return {row["name"]: row for row in json.loads((FOLDER / "speed.json").read_text())["rows"]}


def test_the_speed_result_has_every_row_and_ratios_are_peer_over_ours() -> None:
    rows = speed_rows()
    assert set(rows) >= SPEED_ROWS
    compared = [row for row in rows.values() if "peer_cpu_s" in row]
    assert {row["name"] for row in compared} >= {"rgbd_ids_vs_pyrender", "rgbd_ids_vs_mujoco", "encoding", "scaling"}
    for row in compared:
        assert row["ratio"] == pytest.approx(row["peer_cpu_s"] / row["ours_cpu_s"], rel=1e-3)
        assert row["how"], "a peer without a line on how it is used"
    assert not any("ratio" in row for row in rows.values() if "peer_cpu_s" not in row)


def test_peers_drew_the_same_scene() -> None:
    for name in ("rgbd_ids_vs_pyrender", "rgbd_ids_vs_mujoco"):
        row = speed_rows()[name]
        assert row["scene"]["size_wh"] == [1224, 370]
        assert row["scene"]["lights_with_shadow"] >= 4
        assert row["ids_agree"] > 0.995
        assert row["depth_agrees"] > 0.995


def test_the_shares_of_an_observation_are_those_of_its_stages() -> None:
    row = speed_rows()["full_observation"]
    stages = row["stages_cpu_s"]
    assert set(row["fractions"]) == set(stages) >= {"draw", "read-back", "encode", "disk", "LiDAR", "labels"}
    for stage, seconds in stages.items():
        assert row["fractions"][stage] == pytest.approx(seconds / sum(stages.values()), abs=2e-3)


def test_the_scaling_row_has_its_four_sizes() -> None:
    row = speed_rows()["scaling"]
    assert [size["instances"] for size in row["table"]] == [10, 100, 1_000, 10_000]
    assert row["ours_cpu_s"] == row["table"][-1]["ours_cpu_s"]


def test_memory_was_watched_over_a_thousand_observations() -> None:
    row = speed_rows()["memory"]
    assert (row["observations"], row["scenes"]) == (1_000, 50)
    assert row["value"] == pytest.approx(row["last_mib"] / row["first_mib"], rel=1e-3)
