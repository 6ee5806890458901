"""Shipped suites say what there is, and are bounded by the ground truth above and by chance below."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.benchmark.made import BASELINES, shrunk
from warehouse_sim.benchmark.disturbances import DISTURBANCES
from warehouse_sim.benchmark.result import SuiteResult, read_result
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.sets import recipe_of
from warehouse_sim.benchmark.suite import Suite, load_suite, quickened
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, EvaluationError, UnknownNameError
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import suite_names

SUITES = {name: load_suite(name) for name in suite_names()}
ON_IMAGES = [name for name, suite in SUITES.items() if suite.data]


def test_the_suites_of_the_benchmark_are_here() -> None:
    assert {"industrial"} <= set(SUITES)


@pytest.mark.parametrize("name", SUITES)
def test_a_suite_names_only_what_there_is(name: str, tmp_path: Path) -> None:
    for suite in (SUITES[name], quickened(SUITES[name])):
        assert from_mapping(Suite, to_mapping(suite), name) == suite
        for data_name, data in suite.data.items():
            recipe = recipe_of(data_name, data, tmp_path)
            assert recipe.scene.observations_per_scene == data.observations
            assert recipe.split.test == (0.0 if data.trained_on else 1.0)
        for condition in suite.evaluated.values():
            assert condition.disturb in DISTURBANCES
            from_mapping(PredictConfig, condition.predict, name)


@pytest.mark.parametrize("name", ON_IMAGES)
def test_a_suite_asks_the_ground_truth_chance_and_a_baseline(name: str) -> None:
    for suite in (SUITES[name], quickened(SUITES[name])):
        assert {"oracle", "shuffled"} <= set(suite.estimators)
        assert set(suite.estimators) & set(BASELINES)


def test_seeds_of_what_is_scored_are_those_of_nothing_that_is_bundled() -> None:
    seeds = {data.seed for suite in SUITES.values() for data in suite.data.values()}
    seeds |= {suite.approach.seed for suite in SUITES.values() if suite.approach.recipes}
    assert min(seeds) > 60  # the trainings of benchmarks/estimators have 0-9, its tables 41, 57 and some more


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bench")


def bounded(suite: Suite, out: Path) -> SuiteResult:
    return run_suite(shrunk(suite), ("oracle", "shuffled"), config=RunConfig(out, workers=1))


@pytest.mark.gl
@pytest.mark.parametrize("name", ON_IMAGES)
def test_the_ground_truth_is_right_in_every_number_and_chance_is_not(name: str, out: Path) -> None:
    result = bounded(SUITES[name], out)
    gt = [row for row in result.rows if row.estimator == "oracle"]
    assert {row.table for row in gt} >= {"scores"}
    for row in gt:
        never = row.table in ("effects", "spread") or row.metric in ("as missed", "as nothing", "aborted")
        expected = 0.0 if never else 1.0
        assert row.value == expected, row
    shuffled = [row for row in result.rows if row.estimator == "shuffled" and row.table == "scores"]
    assert shuffled
    for row in shuffled:
        if row.metric != "found" and not row.metric.startswith("auc"):
            assert row.value <= 0.2, row
    assert not [item for item in result.left_out if item.estimator in ("oracle", "shuffled")]


@pytest.mark.gl
def test_what_was_made_is_used_again_and_only_if_nothing_changed(out: Path) -> None:
    suite = SUITES["industrial"]
    first = bounded(suite, out)
    again = bounded(suite, out)
    evaluated = len(shrunk(suite).evaluated) * 2
    assert (again.reused, again.rows) == (evaluated, first.rows)
    more = run_suite(
        shrunk(replace(suite, metrics=("found",))), ("oracle", "shuffled"), config=RunConfig(out, workers=1)
    )
    assert more.reused == evaluated  # a metric is taken from the scores that are there
    name = next(iter(suite.evaluated))
    other = replace(suite, conditions={name: replace(suite.evaluated[name], disturb="boxes only")})
    evaluated_again = run_suite(shrunk(other), ("rectangle-fit",), config=RunConfig(out, workers=1))
    exact = run_suite(shrunk(suite), ("rectangle-fit",), config=RunConfig(out, workers=1))
    assert (evaluated_again.reused, exact.reused) == (0, 0)
    assert run_suite(shrunk(suite), ("rectangle-fit",), config=RunConfig(out, 1, overwrite=True)).reused == 0
    assert run_suite(shrunk(suite), ("rectangle-fit",), config=RunConfig(out, 1)).reused == 1


@pytest.mark.gl
def test_a_result_is_read_back_as_it_was_and_a_changed_one_is_rejected(out: Path) -> None:
    result = bounded(SUITES["industrial"], out)
    path = out / "results" / "industrial.json"
    assert read_result(path) == result
    text = path.read_text()
    for old, new in (
        ('"quick": false', '"quick": "no"'),
        ('"question"', '"qestion"'),
        ('"value": 1.0', '"value": 0.2'),
        ('"n": 6', '"n": 0'),
    ):
        if old not in text:
            continue
        broken = out / "broken.json"
        broken.write_text(text.replace(old, new, 1))
        with pytest.raises(EvaluationError, match=r"broken\.json"):
            read_result(broken)
    assert "[" in path.with_suffix(".md").read_text()


def test_a_suite_that_names_what_there_is_not_is_rejected(tmp_path: Path) -> None:
    cases = {
        "by: [klass]": "no grouping",
        "conditions: {a: {data: nothing}}": "there is no data 'nothing'",
        "trainings: {a: {estimator: x, data: [y], steps: [1]}}": "no data that are trained_on",
        "metric: [add]": "did you mean 'metrics'",
        "edges: {distance: [3, 1]}": "must rise",
    }
    for text, message in cases.items():
        path = tmp_path / "s.yaml"
        path.write_text(f"version: 1\nquestion: q\n{text}\n")
        with pytest.raises(ConfigError, match=message):
            load_suite(str(path))
    with pytest.raises(UnknownNameError, match="industrial"):
        load_suite("industriel")


def test_rows_of_a_suite_are_counted_by_scene(out: Path) -> None:
    result = bounded(SUITES["industrial"], out)
    rows = [row for row in result.rows if row.table == "scores" and row.group == "all"]
    assert {row.scenes for row in rows} == {1}
    assert all(np.ptp(row.interval) > 0.0 for row in rows), "one scene tells little, and the interval says so"
