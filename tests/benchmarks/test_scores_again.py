"""Scores that were stored are read, unless their format or the dataset's records are not those any more."""

import json
import os
from pathlib import Path

import pytest

from benchmarks.estimators.score import SELECTIONS, place_of, score
from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates


@pytest.fixture
def stored(tmp_path: Path) -> tuple[Path, Path, Path]:
    """A model, a dataset and scores of format 5 beside the true poses, all of it some seconds old."""
    data, model, place = make_dataset(tmp_path / "data", 2), tmp_path / "model", place_of(tmp_path, SELECTIONS[0])
    model.mkdir()
    place.mkdir()
    write_estimates(estimates_of(data), place / "predictions.csv")
    (place / "scores.json").write_text(json.dumps({"format": 5}))
    for age, path in ((30, model / "weights.safetensors"), (20, data / "scenes"), (10, place / "scores.json")):
        path.touch()
        os.utime(path, (path.stat().st_atime, path.stat().st_mtime - age))
    return model, data, place / "scores.json"


def test_an_older_format_is_scored_again_without_predicting_again(stored) -> None:
    model, data, file = stored
    (made,) = score(model, data, "test", SELECTIONS[:1], file.parents[1]).values()
    assert made.overall.metrics["add_2pct"] == 1.0
    first = file.stat().st_mtime_ns
    (read,) = score(model, data, "test", SELECTIONS[:1], file.parents[1]).values()
    assert file.stat().st_mtime_ns == first
    assert read.to_plain() == made.to_plain()


def test_records_that_say_more_now_are_scored_again(stored) -> None:
    model, data, file = stored
    score(model, data, "test", SELECTIONS[:1], file.parents[1])
    os.utime(data / "scenes", (0, file.stat().st_mtime + 5))
    for path in (data / "scenes").glob("*.json"):
        record = json.loads(path.read_text())
        for item in record["objects"]:
            if item["class_name"] == "pallet":
                item |= {"dockable": dict.fromkeys(("-x", "+x", "-y", "+y"), "leaning"), "stacked": False}
        path.write_text(json.dumps(record))
    (made,) = score(model, data, "test", SELECTIONS[:1], file.parents[1]).values()
    assert set(made.docking_left_out) == {"leaning"}
    assert made.overall.dockable_count == 0
