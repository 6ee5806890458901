"""On the fixed subset everybody gets the same pallets, one by one, and who takes too long has missed."""

import sys
from pathlib import Path

import pytest

from tests.benchmark.made import bench_folder
from tests.shared import Shared
from warehouse_sim.benchmark import groups
from warehouse_sim.benchmark.entrants.entrant import Evaluated, Oracle, Request
from warehouse_sim.benchmark.entrants.subset import wanted_objects
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.groups import fixed_subset, ground_truths, places_of
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.own.program import ProgramEstimator
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.evaluation import evaluate
from warehouse_sim.schema import PoseEstimate

pytestmark = pytest.mark.gl
CONDITION = ConditionConfig("smoke", seconds_an_object=20.0)
PROGRAM = """
import json, sys, time
for line in sys.stdin:
    for item in json.loads(line)["detections"]:
        time.sleep(SLEEP if item["detection"] == SLOW else 0.0)
        print(json.dumps({"detection": item["detection"], "R": [1, 0, 0, 0, 1, 0, 0, 0, 1], "t": [0, 0, 3]}))
    print("", flush=True)
"""


@pytest.fixture(scope="module")
def reader(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> DatasetReader:
    (root,) = (bench_folder(shared, tmp_path_factory.mktemp("subset")) / "data").glob("smoke-*")
    return DatasetReader(root)


def places(reader: DatasetReader) -> list[tuple[int, int, int]]:
    wanted = wanted_objects(reader, "test")
    return [(image.scene_id, image.image_id, item.gt_index) for image, items in wanted for item in items]


def estimates(name: str, reader: DatasetReader, condition: ConditionConfig = CONDITION) -> list[PoseEstimate]:
    return Evaluated(name, Way(name, PredictConfig())).estimates(
        Request(reader, "test", condition, lambda done, note: None)
    )


def answered(found: list[PoseEstimate]) -> set[tuple[int, int, int]]:
    return {(item.scene_id, item.image_id, item.detection) for item in found}


def program(folder: Path, slow: int, seconds: float) -> str:
    path = folder / "program.py"
    path.write_text(PROGRAM.replace("SLEEP", str(seconds)).replace("SLOW", str(slow)))
    return f"exec:{sys.executable} {path}"


def test_the_subset_is_the_same_whatever_is_estimated(reader: DatasetReader, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = ground_truths(reader, "test")
    scored = evaluate(
        Oracle().estimates(Request(reader, "test", CONDITION, lambda done, note: None)), reader, "test"
    ).table
    for size in (60, 2):
        monkeypatch.setattr(groups, "SUBSET", size)
        rows = fixed_subset(plain)
        assert rows.sum() == min(size, plain.evaluated().sum()) > 1
        assert rows.tolist() == fixed_subset(scored).tolist()
        assert plain.evaluated()[rows].all()
        assert sorted(places(reader)) == sorted(places_of(plain.select(rows)))


def test_an_estimator_gets_the_pallets_of_the_subset_alone(reader: DatasetReader) -> None:
    found = estimates("rectangle-fit", reader)
    assert answered(found) == set(places(reader))
    assert len(places_of(ground_truths(reader, "test"))) > len(found)
    assert all(item.time > 0.0 for item in found)


def test_who_takes_too_long_for_an_object_has_missed_it(reader: DatasetReader, tmp_path: Path) -> None:
    all_places = places(reader)
    slow = all_places[-1][2]
    found = estimates(program(tmp_path, slow, 1.0), reader, ConditionConfig("smoke", seconds_an_object=0.5))
    assert answered(found) == {place for place in all_places if place[2] != slow} != set()


def test_a_program_that_never_answers_is_started_again(
    reader: DatasetReader, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ProgramEstimator.__init__, "__defaults__", (3.0,))
    all_places = places(reader)
    slow = all_places[0][2]
    found = estimates(program(tmp_path, slow, 60.0), reader)
    assert answered(found) == {place for place in all_places if place[2] != slow} != set()
