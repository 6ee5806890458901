"""The time of a run includes reading, and what will fit into it is told in time."""

import json
import time
from dataclasses import replace
from pathlib import Path

import pytest

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.pose.densefusion.training import preparation
from warehouse_sim.estimators.train import train

NAME = "densefusion-pointcloud"
SHORT = TrainConfig(max_minutes=12 / 60, batch=4, validations=2, precision="32", workers=1)


def test_nothing_is_said_when_steps_were_requested_for(toy_root: Path, tmp_path: Path, caplog) -> None:
    for name, config in (
        ("few", replace(SHORT, max_steps=7)),
        ("endless", replace(SHORT, max_steps=7, max_minutes=None)),
    ):
        train(NAME, toy_root, tmp_path / name, config)
    assert "hardly train" not in caplog.text


def test_reading_counts_and_may_leave_nothing(toy_root: Path, tmp_path: Path, monkeypatch) -> None:
    load_crops = preparation.load_crops

    def slowly(*arguments: object):
        time.sleep(1.1)
        return load_crops(*arguments)

    monkeypatch.setattr(preparation, "load_crops", slowly)
    run, config = tmp_path / "run", replace(SHORT, max_minutes=2 / 60)
    with pytest.raises(TrainingError, match=r"reading and .* took \d+ s, which leaves nothing of max_minutes"):
        train(NAME, toy_root, run, config)
    monkeypatch.undo()
    train(NAME, toy_root, run, config, resume=True)
    assert json.loads((run / "result.json").read_text())["steps"] > 0


def test_a_run_whose_time_is_up_validates_once_more_only(toy_root: Path, tmp_path: Path, caplog) -> None:
    def pause(fraction: float, note: str) -> None:
        if note.startswith("step"):
            time.sleep(3.0)

    config = replace(SHORT, max_minutes=3 / 60, validations=8)
    run = train(NAME, toy_root, tmp_path / "run", config, progress=pause, cache=Path("none"))
    # The second step is drawn before the first is done.
    assert json.loads((run / "result.json").read_text())["steps"] <= 2
    assert len((run / "curves.csv").read_text().splitlines()) == 2
    assert "fewer than 100" in caplog.text
