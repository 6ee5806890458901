"""Two trainings in one run folder: the second is rejected, and what the first makes is what it makes alone."""

import re
import signal
import subprocess
import time
from pathlib import Path

import pytest
import torch

from tests.estimators.test_killed_training import checkpoints, finish, start, weights
from tests.test_one_writer import start_holder
from warehouse_sim.errors import OutputError
from warehouse_sim.estimators.detectors.yolov5.settings import DetectorConfig
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.learning.settings import LoopConfig
from warehouse_sim.one_writer import LOCK

NAME = "densefusion-pointcloud"
SETTINGS = {NAME: TrainConfig(), "detector-depth": DetectorConfig(), "segmenter-depth": SegmenterConfig()}
SHORT = ("--max-steps", "12", "--validations", "3")


def rejected(process: subprocess.Popen) -> str:
    """Return the one line of a process that would not begin."""
    said = process.communicate(timeout=300)[1]
    assert process.returncode == 2, said
    assert "Traceback" not in said
    (line,) = [line for line in said.splitlines() if line.startswith("error")]
    return line


def files(run: Path) -> dict[str, bytes]:
    return {path.relative_to(run).as_posix(): path.read_bytes() for path in run.rglob("*") if path.is_file()}


@pytest.mark.slow
def test_a_second_training_is_rejected_and_the_first_ends_as_if_alone(toy_root: Path, tmp_path: Path) -> None:
    alone, run = tmp_path / "alone", tmp_path / "run"
    finish(start(NAME, toy_root, alone, *SHORT))
    first = start(NAME, toy_root, run, *SHORT)
    while not checkpoints(run) and first.poll() is None:
        time.sleep(0.005)
    first.send_signal(signal.SIGSTOP)  # between two checkpoints, for as long as it takes
    try:
        before = files(run)
        for more in ((), ("--resume",)):
            line = rejected(start(NAME, toy_root, run, *SHORT, *more))
            assert re.fullmatch(rf"error: .*run: process {first.pid} on \S+ is writing there; .*", line), line
        assert files(run) == before
    finally:
        first.send_signal(signal.SIGCONT)
    finish(first)
    assert not (run / LOCK).exists()
    expected, found = weights(alone), weights(run)
    assert expected.keys() == found.keys()
    assert all(torch.equal(value, found[key]) for key, value in expected.items())
    lines = [(folder / "curves.csv").read_text(encoding="utf-8").count("\n") for folder in (alone, run)]
    assert lines[0] == lines[1]


@pytest.mark.parametrize(("name", "settings"), SETTINGS.items())
def test_whatever_trains_keeps_out_of_a_folder_that_is_written(
    name: str, settings: LoopConfig, toy_root: Path, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    holder = start_holder(run)
    try:
        for resume in (False, True):
            with pytest.raises(OutputError, match=rf"run: process {holder.pid} on .* is writing there"):
                train(name, toy_root, run, settings, resume)
        assert [path.name for path in run.iterdir()] == [LOCK]
    finally:
        holder.communicate("\n")
