"""What is evaluated, what is left out and what is kept."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.benchmark.docking.planted import AXES, KINDS, limits, planted
from tests.benchmark.docking.stations import estimate, station
from warehouse_sim.benchmark.docking import record
from warehouse_sim.benchmark.docking.questions import Question, swept_answer, why_not
from warehouse_sim.benchmark.docking.record import Kept, answer
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.benchmark.docking.world import pieces
from warehouse_sim.catalog import catalog_object
from warehouse_sim.evaluation.docking import mesh_sweep
from warehouse_sim.geometry.boxes import OrientedBox


def evaluated(face, **errors: float) -> Question:
    return Question("made", 0, 0, 1, face.name, "oracle", estimate(station(), face.name, **errors))


# Yaw turns the wide pair of tines of the long side past the face before it uses up the clearance beside them.
@pytest.mark.parametrize(("name", "axis"), [*(("-x", axis) for axis in AXES), ("+y", "lateral"), ("+y", "vertical")])
def test_limits_are_where_the_swept_test_turns(name: str, axis: str) -> None:
    place = station()
    face = place.face(name)
    for sign, limit in zip((-1.0, 1.0), limits(face)[axis], strict=True):
        for fraction, docks in ((0.97, True), (1.03, False)):
            swept = swept_answer(evaluated(face, **{axis: sign * fraction * limit}), place)
            clearance = swept["clearance"] | {"mesh": swept["clearance_nominal"]}
            assert docks is (min(clearance.values()) >= 0.0), (sign, fraction)


def test_planted_errors_are_the_same_again_and_spread_around_the_limits() -> None:
    place = station()
    face = place.face("-x")
    draws = [planted("lateral", place, face, np.random.default_rng(seed)) for seed in range(200)]
    aside = [abs(float(np.linalg.inv(face.T_object_dock)[1] @ T @ face.T_object_dock[:, 3])) for T in draws]
    assert max(aside) == pytest.approx(0.1275, rel=0.03)
    assert 0.4 < np.mean(np.array(aside) < 0.06375) < 0.6
    for kind in KINDS:
        one, two = (planted(kind, place, face, np.random.default_rng(5)) for _ in range(2))
        np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(planted("oracle", place, face, np.random.default_rng(0)), np.eye(4))


def test_every_board_of_a_pallet_is_a_box_of_its_own() -> None:
    model = catalog_object("epal1")
    shapes = [shape for _, shape in pieces(model) if isinstance(shape, OrientedBox)]
    assert len(shapes) == len(model.parts) == 5 + 3 + 9 + 3  # deck, stringers, blocks, skids
    found, built = (
        sorted(tuple(np.sort(size).round(4).tolist()) for size in sizes)
        for sizes in ([shape.size for shape in shapes], [part.scale for part in model.parts])
    )
    assert found == built


def test_what_scores_do_not_ask_for_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    place = station()
    face = place.face("-x")
    assert [why_not(place, face, word) for word in ("free", "under a stack")] == ["", ""]
    assert why_not(place, face, "blocked by rack") == "blocked by rack"
    monkeypatch.setattr(mesh_sweep, "TINE_THICKNESS", 0.11)
    assert why_not(place, face, "free") == "no clearance for the tines"


def test_what_was_answered_is_not_requested_again(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, path = station(), tmp_path / "answers.jsonl"
    face = place.face("-x")
    first = answer(Kept(path), evaluated(face), place)
    with path.open("a") as file:
        file.write('{"key": "cut sho')  # a run that was stopped
    again = Kept(path)
    assert answer(again, evaluated(face), place) == json.loads(json.dumps(first))
    assert len(path.read_text().splitlines()) == 2
    monkeypatch.setattr(record, "TRUCK", replace(TRUCK, speed=0.15))
    other = answer(Kept(path), evaluated(face), place)
    assert other["key"] != first["key"]


def test_rows_survive_a_line_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "new" / "rows.jsonl"
    kept = Kept(path)
    kept.add("a", {"n": 1})
    kept.add("b", {"n": 2})
    path.write_text(path.read_text()[:-7])  # killed while it wrote
    again = Kept(path)
    assert "a" in again
    assert "b" not in again
    again.add("c", {"n": 3})
    again.add("d", {"n": 4})
    last = Kept(path)
    assert [last[key]["n"] for key in "acd"] == [1, 3, 4]
