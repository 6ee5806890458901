"""Precision in millimetres is that of the BOP scores, with an interval over scenes; times stand with their machine."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from warehouse_sim.benchmark.entrants.entrant import Group, ResultFile
from warehouse_sim.benchmark.report.board import boards
from warehouse_sim.benchmark.report.markdown import page
from warehouse_sim.benchmark.result import DataFacts, EstimatorFacts, SuiteResult
from warehouse_sim.benchmark.rows.precision import AP_MM, precision_row, resampled
from warehouse_sim.benchmark.rows.row import SECONDS, WORST
from warehouse_sim.benchmark.rows.scores import metric_columns, score_rows, worst_rows
from warehouse_sim.benchmark.scored import Answer, Opened, scored
from warehouse_sim.benchmark.sets import MadeSet
from warehouse_sim.benchmark.suite import ConditionConfig, Suite
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.precision_recall import Matches, average_precision
from warehouse_sim.evaluation import evaluate
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import PoseEstimate


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("precision") / "data")


def answer(data: Path, out: Path, estimates: list[PoseEstimate]) -> Answer:
    file = write_estimates(estimates, out / "made.csv")
    group = Group("me", (ResultFile("me", file),))
    opened = Opened(MadeSet("made", data), DatasetReader(data), {})
    scores, _ = scored(group.members[0], ConditionConfig("made"), opened, out)
    return Answer(group, "made", opened, (scores,), "a processor, 2 cores")


def test_a_shift_in_millimetres_has_its_precision(data: Path, tmp_path: Path) -> None:
    ahead = make_transform(None, np.array([0.0, 0.0, 0.0111]))  # passes 12, 14 ... 20 mm, five of ten
    shifted = [replace(item, T_camera_object=ahead @ item.T_camera_object) for item in estimates_of(data)]
    for estimates, expected in ((estimates_of(data), 1.0), (shifted, 0.5)):
        row = precision_row(answer(data, tmp_path, estimates))
        assert (row.value, row.metric, row.scenes) == (expected, AP_MM, 2)
        assert row.interval[0] <= expected <= row.interval[1]
        assert np.ptp(row.interval) > 0.0


def test_a_bootstrap_with_each_scene_once_is_the_precision_itself() -> None:
    rng, parts = np.random.default_rng(3), []
    for scene in (4, 4, 7, 9):
        scores = np.sort(rng.random(6))[::-1]
        parts.append((scene, Matches(scores, rng.random(6) < 0.6, rng.random(6) < 0.2, 5)))
    assert 0.2 < average_precision([item for _, item in parts]) < 0.9
    picks = np.array([[1, 1, 1], [2, 0, 1], [0, 0, 0]])
    once, twice, none = resampled(parts, [4, 7, 9], picks)
    assert once == pytest.approx(average_precision([item for _, item in parts]))
    assert twice == pytest.approx(
        average_precision([item for s, item in parts if s != 7 for _ in range(1 + (s == 4))]), abs=0.05
    )
    assert np.isnan(none)


def test_a_failure_counts_as_unwarned_where_its_bound_promised_more(data: Path) -> None:
    aside = make_transform(None, np.array([0.0, 0.15, 0.0]))
    off = [replace(item, T_camera_object=item.T_camera_object @ aside) for item in estimates_of(data)]
    for bound, expected in ((0.005, 0.0), (0.5, 1.0)):
        found = [replace(item, error_bound=bound) for item in off]
        table = evaluate(found, DatasetReader(data), "test").table
        column = metric_columns(table)["no_unwarned_failure"]
        assert set(column[table.evaluated()]) == {expected}
        assert np.isnan(column[~table.evaluated()]).all()
    right = evaluate([replace(item, error_bound=0.005) for item in estimates_of(data)], DatasetReader(data), "test")
    assert set(metric_columns(right.table)["no_unwarned_failure"][right.table.evaluated()]) == {1.0}
    silent = evaluate(off, DatasetReader(data), "test").table
    assert np.isnan(metric_columns(silent)["no_unwarned_failure"]).all()


def test_the_run_time_stands_beside_its_machine(data: Path, tmp_path: Path) -> None:
    mine = answer(data, tmp_path, [replace(item, time=0.25) for item in estimates_of(data)])
    rows = list(score_rows(mine, Suite(1, "q", metrics=("dock_0mm", AP_MM))))
    (timed,) = [row for row in rows if row.table == "time"]
    assert (timed.metric, timed.value, timed.n, timed.machine) == (SECONDS, 0.25, 4, "a processor, 2 cores")
    worst = list(worst_rows(rows, ["made"]))
    assert {(row.table, row.condition) for row in worst} == {("scores", WORST), ("time", WORST)}
    facts = DataFacts("made", "", "ab12", None, 2, 4, 10)
    result = SuiteResult("q-v1", "q", False, "", {}, 1.0, 0, (facts,), (EstimatorFacts("me", 0),), (*worst, *rows))
    assert "0.25 s [0.25, 0.25] on a processor, 2 cores" in page(result)
    assert [board.is_timed for board in boards(result)] == [True, True]
    untimed = answer(data, tmp_path, [replace(item, time=-1.0) for item in estimates_of(data)])
    assert not [row for row in score_rows(untimed, Suite(1, "q")) if row.table == "time"]
