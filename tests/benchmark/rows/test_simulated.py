"""A simulation that is registered is evaluated about every answer of a suite; its verdicts become rows."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from tests.benchmark.rows.test_effects import answer
from tests.evaluation.made_dataset import make_dataset
from warehouse_sim.benchmark.entrants.entrant import entrant
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.rows import simulated
from warehouse_sim.benchmark.rows.simulated import Drive, Verdict, driven_rows, simulated_rows
from warehouse_sim.benchmark.suite import ApproachConfig
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.registry import Registry


def every_second_docks(data: Path, predictions: Path, split: str, most: int) -> list[Verdict]:
    assert (data / "manifest.json").is_file()
    assert split == "test"
    rows = prediction_file.read(predictions)[:most]
    return [Verdict(item.scene_id, docked=number % 2 == 0, swept=True) for number, item in enumerate(rows)]


def test_verdicts_become_shares_with_intervals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    registry = Registry("docking simulation")
    registry.add("coin", f"{__name__}:every_second_docks")
    monkeypatch.setattr(simulated, "SIMULATIONS", registry)
    evaluated = answer(make_dataset(tmp_path / "data"), tmp_path, "me", "c", 0.0)
    rows = {row.metric: row for row in simulated_rows(evaluated, tmp_path / "out", 7)}
    count = min(len(evaluated.scores[0].estimates), 7)
    docked = (count + 1) // 2 / count
    assert rows["docked"].value == pytest.approx(docked, abs=1e-5)
    assert rows["swept_docked"].value == 1.0
    assert rows["swept_agrees"].value == rows["docked"].value
    assert {(row.table, row.group, row.n) for row in rows.values()} == {("simulated", "coin", count)}
    assert all(row.interval[0] < row.interval[1] for row in rows.values())


def drives_as_planned(
    config: ApproachConfig, ways: Mapping[str, Way], inputs: Mapping[str, object], out: Path
) -> Iterator[Drive]:
    assert out.is_dir()
    assert set(ways) == set(inputs) == {"rectangle-fit"}
    for method in ("oracle", *ways):
        for number in range(config.episodes):
            docked = method == "oracle" or number % 2 == 0
            yield Drive(method, config.recipes[0], "base", number, docked, not docked)


def test_approaches_become_shares_of_those_who_see(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    registry = Registry("closed loop")
    registry.add("planned", f"{__name__}:drives_as_planned")
    monkeypatch.setattr(simulated, "CLOSED_LOOPS", registry)
    groups = [entrant(name) for name in ("oracle", "shuffled", "rectangle-fit", "icp-multistart")]
    config = ApproachConfig(("smoke",), episodes=10, estimators=("rectangle-fit",))
    rows = {(row.estimator, row.metric): row for row in driven_rows(groups, config, tmp_path)}
    assert {key: row.value for key, row in rows.items()} == {
        ("oracle", "docked"): 1.0,
        ("oracle", "aborted"): 0.0,
        ("rectangle-fit", "docked"): 0.5,
        ("rectangle-fit", "aborted"): 0.5,
    }
    assert {(row.table, row.condition, row.n, row.scenes) for row in rows.values()} == {("driven", "smoke", 10, 10)}
    assert all(row.interval[0] < row.interval[1] for row in rows.values())
    assert not list(driven_rows(groups, ApproachConfig(), tmp_path))
