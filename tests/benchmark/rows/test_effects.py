"""Paired effects have the value that was planted, and intervals that hold as often as they say."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from tests.evaluation.pallet import nudge
from warehouse_sim.benchmark.entrants.entrant import entrant
from warehouse_sim.benchmark.rows.effects import effect_rows
from warehouse_sim.benchmark.scored import Answer, Opened, scored
from warehouse_sim.benchmark.sets import MadeSet
from warehouse_sim.benchmark.suite import CompareConfig, ConditionConfig, Suite
from warehouse_sim.dataset.reader import DatasetReader

METRICS = ("add_2pct", "add_10pct", "found")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("effects") / "data")


def answer(data: Path, out: Path, name: str, condition: str, shift: float, every: int = 1) -> Answer:
    """Ask somebody whose poses are ``shift`` (m) off in every so manyth estimate."""
    rows = [
        replace(item, T_camera_object=item.T_camera_object @ nudge(y=shift)) if number % every == 0 else item
        for number, item in enumerate(estimates_of(data))
    ]
    file = write_estimates(rows, out / f"{name}.csv")
    group = replace(entrant(str(file)), name=name.split("-")[0])
    opened = Opened(MadeSet("made", data), DatasetReader(data), {})
    scores, _ = scored(group.members[0], ConditionConfig("made"), opened, out)
    return Answer(group, condition, opened, (scores,))


def test_what_was_planted_is_found(data: Path, tmp_path: Path) -> None:
    exact, off = (answer(data, tmp_path, f"me-{shift}", f"{shift}", shift) for shift in (0.0, 0.03))
    suite = Suite(1, "q", metrics=METRICS)
    rows = {row.metric: row for row in effect_rows([exact, off], suite, CompareConfig("shift", against="0.0"))}
    # 3 cm are more than 2 % and less than 10 % of the diameter of pallet and carton.
    assert {metric: row.value for metric, row in rows.items()} == {"add_2pct": -1.0, "add_10pct": 0.0, "found": 0.0}
    assert {row.group for row in rows.values()} == {"shift: 0.03"}
    assert rows["add_2pct"].against == "0.0"
    assert rows["add_2pct"].n == len(exact.scores[0].table)
    back = {row.metric: row for row in effect_rows([exact, off], suite, CompareConfig("shift", against="0.03"))}
    assert back["add_2pct"].value == 1.0


def test_two_estimators_are_compared_on_the_same_rows(data: Path, tmp_path: Path) -> None:
    right, half = answer(data, tmp_path, "right", "c", 0.0), answer(data, tmp_path, "half", "c", 0.05, every=2)
    suite = Suite(1, "q", metrics=METRICS)
    compare = CompareConfig("who", between=(("half", "right"), ("half", "nobody")))
    rows = {row.metric: row for row in effect_rows([right, half], suite, compare)}
    own = half.scores[0].table.add < 0.02 * half.scores[0].table.diameter
    assert rows["add_2pct"].value == pytest.approx(own.mean() - 1.0, abs=1e-5)
    assert (rows["add_2pct"].estimator, rows["add_2pct"].against) == ("half", "right")
    assert rows["found"].interval[0] < 0.0 < rows["found"].interval[1], "nothing changed in few pairs is no proof"
