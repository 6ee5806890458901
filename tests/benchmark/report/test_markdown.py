"""Pages show an interval in every cell, say when an effect is clear of zero, and what is behind a number."""

from dataclasses import replace
from pathlib import Path

import pytest

from warehouse_sim.benchmark.kept import digest, file_digest, folder_for, is_kept, keep
from warehouse_sim.benchmark.report.markdown import page, summary
from warehouse_sim.benchmark.result import DataFacts, EstimatorFacts, LeftOut, SuiteResult, read_result, write_result
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.errors import EvaluationError

ROW = Row("scores", "net", "industrial", "all", "add_10pct", 0.99996, (0.98, 1.0), 200, 4, 1)
EFFECT = Row("effects", "net", "paired_variants", "light: dim", "add_10pct", -0.12, (-0.2, -0.04), 80, 4, 1, "base")
RESULT = SuiteResult(
    "industrial-v1",
    "How good?",
    True,
    "warehouse-sim bench industrial --quick",
    {"cores": 2},
    12.5,
    0,
    (DataFacts("industrial", "industrial-v1", "ab12", 61, 4, 8, 200, {"stacked": 3}),),
    (EstimatorFacts("net", 1, "cd34"), EstimatorFacts("nobody", 0)),
    (ROW, replace(ROW, metric="dock_0mm", value=0.5, interval=(0.4, 0.6), n=20), EFFECT),
    (LeftOut("nobody", "industrial", "has no weights"),),
)


def test_a_page_has_an_interval_in_every_cell() -> None:
    text = page(RESULT)
    assert "99.9 [98, 100]" in text, "100 is kept for what is all"
    assert "50.0 [40, 60] of 20" in text
    assert "**-12.0 [-20.0, -4.0]**" in text
    assert text.count("4 scenes, one training") == 2
    assert "--quick" in text
    assert "3 stacked" in text
    assert "nobody, industrial: has no weights" in text


def test_of_many_reasons_the_most_frequent_are_named_and_the_others_counted() -> None:
    left_out = {"stacked": 3, "blocked": 9, "outside the aisle": 5, "no room": 2, "mast blocked": 1}
    text = page(replace(RESULT, data=(replace(RESULT.data[0], left_out_of_docking=left_out),)))
    assert "not evaluated for: 9 blocked, 5 outside the aisle, 3 stacked, 3 for other reasons" in text


def test_an_effect_that_may_be_nothing_is_not_bold() -> None:
    unclear = replace(EFFECT, interval=(-0.2, 0.01))
    text = page(replace(RESULT, rows=(ROW, unclear)))
    assert "**" not in text
    assert "-12.0 [-20.0, +1.0]" in text


def test_the_first_lines_name_size_and_what_was_not_scored() -> None:
    lines = list(summary(RESULT))
    assert lines[0].startswith("Run at the small sizes")
    assert any("4 scenes, 8 images, 200 ground truths" in line for line in lines)
    assert any(line.startswith("not scored: nobody") for line in lines)


def test_several_trainings_are_counted_and_none_is_silent() -> None:
    assert replace(ROW, trainings=3).over == "4 scenes, 3 trainings"
    assert replace(ROW, trainings=0, scenes=1).over == "1 scene"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"value": 0.5', '"value": 0.7', "outside its interval"),
        ('"n": 20,', '"n": 0,', "n and scenes must be 1 or more"),
        ('"metric": "dock_0mm"', '"metric": "add_10pct"', "comes twice"),
        ('"table": "effects", "estimator": "net"', '"table": "effects", "estimator": "other"', "not among those"),
        ('"quick": true', '"quick": 1', "quick must be bool"),
        ('"format": 1', '"format": 2', "format must be 1"),
        ('"question"', '"qestion"', "did you mean 'question'"),
    ],
)
def test_a_result_that_cannot_be_is_rejected(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = write_result(RESULT, tmp_path / "r.json")
    assert read_result(path) == RESULT
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(EvaluationError, match=message):
        read_result(path)


def test_what_is_kept_is_known_by_all_that_it_was_made_of(tmp_path: Path) -> None:
    inputs = {"seed": 1, "recipe": {"a": [1, 2]}}
    assert digest(inputs) == digest({"recipe": {"a": [1, 2]}, "seed": 1})
    place = folder_for(tmp_path, "a name/with +words", inputs)
    assert place.parent == tmp_path
    assert folder_for(tmp_path, "a name/with +words", inputs | {"seed": 2}) != place
    assert not is_kept(place, inputs)
    place.mkdir()
    keep(place, inputs)
    assert is_kept(place, inputs)
    assert not is_kept(place, inputs | {"seed": 2})
    (place / "inputs.json").write_text("{")
    assert not is_kept(place, inputs)
    first = file_digest(place)
    (place / "weights").write_bytes(b"1")
    assert file_digest(place) != first
