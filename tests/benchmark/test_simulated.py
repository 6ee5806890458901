"""A simulation that is registered is asked about every answer of a suite; its verdicts become rows."""

from pathlib import Path

import pytest

from tests.benchmark.test_effects import answer
from tests.evaluation.made_dataset import make_dataset
from warehouse_sim.benchmark import simulated
from warehouse_sim.benchmark.simulated import Verdict, simulated_rows
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.registry import Registry


def every_second_docks(data: Path, predictions: Path, split: str) -> list[Verdict]:
    assert (data / "manifest.json").is_file()
    assert split == "test"
    rows = prediction_file.read(predictions)
    return [Verdict(item.scene_id, docked=number % 2 == 0, swept=True) for number, item in enumerate(rows)]


def test_verdicts_become_shares_with_intervals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    registry = Registry("docking simulation")
    registry.add("coin", f"{__name__}:every_second_docks")
    monkeypatch.setattr(simulated, "SIMULATIONS", registry)
    asked = answer(make_dataset(tmp_path / "data"), tmp_path, "me", "c", 0.0)
    rows = {row.metric: row for row in simulated_rows(asked, tmp_path / "out")}
    count = len(asked.scores[0].estimates)
    docked = (count + 1) // 2 / count
    assert rows["docked"].value == pytest.approx(docked, abs=1e-5)
    assert rows["swept_docked"].value == 1.0
    assert rows["swept_agrees"].value == rows["docked"].value
    assert {(row.table, row.group, row.n) for row in rows.values()} == {("simulated", "coin", count)}
    assert all(row.interval[0] < row.interval[1] for row in rows.values())
