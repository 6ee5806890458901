"""Shipped suites say what there is, and are bounded by the ground truth above and by chance below."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.benchmark.made import bench_folder, only_scored, shrunk
from tests.shared import Shared
from warehouse_sim.benchmark.disturbances import DISTURBANCES
from warehouse_sim.benchmark.entrants.entrant import LADDER
from warehouse_sim.benchmark.result import SuiteResult, read_result
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.sets import recipe_of
from warehouse_sim.benchmark.suite import Suite, load_suite, quickened
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, UnknownNameError
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
def test_every_table_has_the_ladder_from_chance_to_ground_truth(name: str) -> None:
    for suite in (SUITES[name], quickened(SUITES[name])):
        plain = [item.removesuffix("+lidar") for item in suite.estimators]
        assert [item for item in plain if item in LADDER] == list(LADDER)
        assert plain[-2:] == list(LADDER[-2:]), "methods stand before the ceiling"


def test_seeds_of_what_is_scored_are_those_of_nothing_that_is_bundled() -> None:
    seeds = {data.seed for suite in SUITES.values() for data in suite.data.values()}
    seeds |= {suite.approach.seed for suite in SUITES.values() if suite.approach.recipes}
    assert min(seeds) > 60  # those of trainings/data.py have 0-9 or more than 1,900, and the fit of uncertainty 8


def test_the_fixed_subset_is_of_the_same_warehouses() -> None:
    whole, subset = SUITES["warehouses"], SUITES["warehouses-subset"]
    assert subset.data == whole.data
    assert quickened(subset).data == quickened(whole).data
    for name, condition in whole.conditions.items():
        assert replace(condition, seconds_an_object=20.0) == subset.conditions[name]


@pytest.fixture(scope="module")
def out(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bench_folder(shared, tmp_path_factory.mktemp("bench"))


@pytest.mark.gl
@pytest.mark.parametrize("name", ON_IMAGES)
def test_the_ground_truth_is_right_in_every_number_and_chance_is_not(name: str, out: Path) -> None:
    result = run_suite(shrunk(SUITES[name]), ("oracle", "shuffled"), config=RunConfig(out, workers=1))
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
    whole = [row for row in result.rows if row.table == "scores" and row.group == "all"]
    assert {row.scenes for row in whole} == {1}
    assert all(np.ptp(row.interval) > 0.0 for row in whole), "one scene tells little, and the interval says so"
    path = out / "results" / f"{name}.json"
    assert read_result(path) == result
    assert "[" in path.with_suffix(".md").read_text()


@pytest.mark.gl
def test_what_was_made_is_used_again_and_only_if_nothing_changed(out: Path) -> None:
    suite = only_scored(SUITES["industrial"])

    def rerun(suite: Suite, *who: str, overwrite: bool = False) -> SuiteResult:
        return run_suite(suite, who or ("oracle", "shuffled"), config=RunConfig(out, 1, overwrite))

    first, again = rerun(suite), rerun(suite)
    evaluated = len(suite.evaluated) * 2
    assert (again.reused, again.rows) == (evaluated, first.rows)
    more = rerun(replace(suite, metrics=("found",)))
    assert more.reused == evaluated  # a metric is taken from the scores that are there
    name = next(iter(suite.evaluated))
    other = replace(suite, conditions={name: replace(suite.evaluated[name], disturb="boxes only")})
    assert [rerun(item, "rectangle-fit").reused for item in (other, suite)] == [0, 0]
    assert rerun(suite, "rectangle-fit", overwrite=True).reused == 0
    assert rerun(suite, "rectangle-fit").reused == 1


@pytest.mark.gl
def test_who_does_not_run_stays_in_the_stored_result(out: Path, tmp_path: Path) -> None:
    suite = only_scored(SUITES["industrial"])

    def rerun(*who: str, overwrite: bool = False) -> tuple[SuiteResult, SuiteResult]:
        found = run_suite(suite, who, config=RunConfig(out, 1, overwrite))
        return found, read_result(out / "results" / "industrial.json")

    alone, stored = rerun("oracle", overwrite=True)
    assert stored == alone
    more, stored = rerun("shuffled")
    assert {item.name for item in more.estimators} == {"shuffled"}
    assert stored.rows == alone.rows + more.rows
    again, stored = rerun("oracle")
    assert stored.rows == more.rows + again.rows
    (tmp_path / "other.csv").write_text(
        "scene_id,im_id,obj_id,score,R,t,time\n0,999,1,0.5,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n"
    )
    failed, stored = rerun("shuffled", str(tmp_path / "other.csv"))
    assert failed.left_out
    nobody, stored = rerun(str(tmp_path / "other.csv"))
    assert not nobody.rows
    assert stored.rows == again.rows + failed.rows
    assert stored.data == alone.data
    assert rerun("shuffled", overwrite=True)[1].rows == more.rows


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
