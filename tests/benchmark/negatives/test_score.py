"""What must not be taken is rejected from the score on that takes pallets, and halls are shown once to each."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.front_ends.negatives import summary
from warehouse_sim.benchmark.entrants.entrant import Evaluated, entrant
from warehouse_sim.benchmark.negatives import score
from warehouse_sim.benchmark.negatives.score import ALL, Hall, negative_rows, threshold
from warehouse_sim.benchmark.negatives.things import KINDS, NOTHING, PALLET
from warehouse_sim.benchmark.negatives.trials import accepted, trials
from warehouse_sim.benchmark.suite import NegativesConfig, load_suite
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import PoseEstimate

CONFIG = NegativesConfig(("smoke",), 3, 2, 1)


def test_the_score_that_counts_is_that_of_95_of_100_pallets() -> None:
    right = [0.5 + number / 1000 for number in range(100)]
    assert 0.503 <= threshold(right) <= 0.506
    assert 0.0 < threshold([0.0] * 10) < 1e-6, "pallets that are all missed accept nothing"


def test_shares_of_a_summary_are_counted_from_that_score_on() -> None:
    scores = {kind: [(0.0, 0.0)] * 10 for kind in KINDS}
    scores["pallet"] = [(0.5 + number / 1000, 0.0) for number in range(100)]
    scores["shelf"] = [(0.0, 0.9), *[(0.0, 0.45)] * 9]
    rows = {row["kind"]: row for row in summary(scores, "x")}
    assert rows["pallet"]["value"] >= 0.95
    assert rows["shelf"]["value"] == pytest.approx(0.1)
    assert rows["three cartons"]["value"] == 0.0


def test_full_suites_have_thousands_of_negatives_and_hundreds_of_starts() -> None:
    negatives, approach = load_suite("negatives").negatives, load_suite("approaches").approach
    assert len(negatives.recipes) * negatives.scenes * negatives.places * (len(KINDS) - 1) >= 3_000
    assert len(approach.recipes) * approach.episodes >= 200
    assert len(approach.recipes) >= 4


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Replace halls: pallets are right at 0.9, a shelf is taken at 0.95 in the second hall; return which were made."""
    made: list[int] = []

    def make(hall: Hall) -> None:
        made.append(hall.index)
        for member in hall.members:
            rows = [(kind, 0.9 * (kind == PALLET), 0.95 * (kind == "shelf" and hall.index == 1)) for kind in KINDS]
            path = hall.file(member)
            path.parent.mkdir(parents=True, exist_ok=True)
            score.write_json(path, rows)

    monkeypatch.setattr(Hall, "make", make)
    return made


def test_rows_say_what_is_rejected_and_the_truth_is_right_in_each(planned: list[int], tmp_path: Path) -> None:
    groups = [entrant(name) for name in ("oracle", "shuffled", "rectangle-fit", "densefusion-nobody-has")[:3]]
    rows, left_out = negative_rows(groups, CONFIG, tmp_path, 1)
    assert not left_out
    found = {(row.estimator, row.group): row.value for row in rows}
    assert {value for (name, _), value in found.items() if name == "oracle"} == {1.0}
    assert found["rectangle-fit", PALLET] == 1.0
    assert found["rectangle-fit", "shelf"] == 0.5
    assert found["rectangle-fit", ALL] == 0.9
    assert {row.n for row in rows if row.group == ALL} == {10}
    assert {row.metric for row in rows} == {"accepted", "rejected"}
    assert planned == [0, 1]
    again, _ = negative_rows(groups, CONFIG, tmp_path, 1)
    assert (planned, again) == ([0, 1], rows)


def test_who_cannot_reject_is_left_out(planned: list[int], tmp_path: Path) -> None:
    (group,) = (entrant("densefusion-depth"),)
    member = group.members[0]
    assert isinstance(member, Evaluated)
    config = replace(member.way.config, reject_blocked=True, selection="weighted-50", refine="none")
    wary = replace(group, members=(replace(member, way=replace(member.way, config=config)),))
    rows, left_out = negative_rows([wary], CONFIG, tmp_path, 1)
    assert not rows
    assert "cannot reject" in left_out[0].reason


@pytest.mark.gl
def test_trials_of_a_hall_show_each_kind_at_one_place() -> None:
    class Sure:
        """Says that a pallet stands where one truly does, or else at the place."""

        finds_objects = True

        def __init__(self, T) -> None:
            self.T = T

        def estimate(self, image) -> list[PoseEstimate]:
            return [PoseEstimate(image.scene_id, image.image_id, 1, 0.8, self.T)]

    with open_renderer("raster") as renderer:
        found = list(trials("industrial", 1921, 0, 1, renderer))
    assert [trial.kind for trial in found] == list(KINDS)
    pallet = found[0].T_camera_pallet
    assert pallet is not None
    for trial in found:
        expected = (0.8, 0.0) if trial.kind in (PALLET, "ghost pocket") else (0.0, 0.8)
        assert accepted(trial, Sure(pallet)) == expected, trial.kind
    assert found[-1].kind == NOTHING
    assert found[-1].ids == ()


@pytest.mark.gl
def test_a_hall_is_shown_to_an_estimator_and_kept(tmp_path: Path) -> None:
    (group,) = (entrant("rectangle-fit"),)
    member = group.members[0]
    assert isinstance(member, Evaluated)
    rows, left_out = negative_rows([group], NegativesConfig(("industrial",), 1921, 1, 1), tmp_path, 1)
    assert not left_out
    assert {row.n for row in rows if row.group == ALL} == {len(KINDS) - 1}
    hall = Hall("industrial", 1921, 0, 1, (member,), tmp_path)
    assert hall.is_made
    assert [kind for kind, _, _ in hall.scores(member)] == list(KINDS)
    assert hall.scores(member)[-1] == (NOTHING, 0.0, 0.0), "without a mask it answers nothing"
