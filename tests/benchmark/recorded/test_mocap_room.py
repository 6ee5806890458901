"""A third-party BOP folder runs unchanged through predict, evaluate and the suite of recorded frames."""

import json
from pathlib import Path

import pytest

from tests.benchmark.recorded.mocap_room import write_room
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.cli.main import main


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_room(tmp_path_factory.mktemp("room") / "hall")


def test_a_room_with_motion_capture_is_predicted_and_scored(room: Path, tmp_path: Path) -> None:
    csv, scored = tmp_path / "icp_hall-test.csv", tmp_path / "scored"
    for command in (
        ("predict", "icp-multistart", "--data", room, "--out", csv),
        ("evaluate", csv, "--data", room, "--out", scored, "--bop"),
    ):
        assert main([str(word) for word in command]) == 0, command
    scores = json.loads((scored / "scores.json").read_text())
    assert scores["counts"]["ground_truths"] == scores["counts"]["found"] == 12
    assert scores["overall"]["metrics"]["add_10pct"] >= 0.7
    assert 0.2 < scores["bop"]["ap_mssd_mm"] <= 1.0


def test_the_suite_has_the_trivial_methods_beside_each(room: Path, tmp_path: Path) -> None:
    who = ("oracle", "shuffled", "rectangle-fit", "icp-multistart")
    result = run_suite(load_suite("real"), who, config=RunConfig(tmp_path, workers=1), data=room.parent)
    assert not result.left_out
    found = {row.estimator: row.value for row in result.rows if row.metric == "add_10pct"}
    assert found["oracle"] == 1.0
    assert found["shuffled"] == 0.0
    assert found["icp-multistart"] >= 0.7
    assert 0.3 < found["rectangle-fit"] < 1.0
    assert {row.estimator for row in result.rows if row.table == "time"} == {"rectangle-fit", "icp-multistart"}
