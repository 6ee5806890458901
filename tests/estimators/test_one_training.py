"""Two trainings in one run folder: the second is rejected, and what the first makes is what it makes alone."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import safetensors.torch
import torch

from tests.processes import descendants, is_alive, scene_workers
from tests.shared import Shared
from tests.test_one_writer import start_holder
from warehouse_sim.errors import OutputError
from warehouse_sim.estimators.detectors.settings import DetectorConfig
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


# A training whose process is killed goes on to the weights of one that was left alone, bit for bit.


COMMON = ("--max-minutes", "None", "--max-steps", "60", "--validations", "6", "--precision", "32", "--threads", "1")
METHODS = {
    "densefusion-pointcloud": ("--batch", "4", "--cache", "none"),
    "detector-depth": ("--batch", "2", "--cache", "none", "--workers", "2"),
    "segmenter-depth": ("--batch", "2", "--cache", "none", "--workers", "2"),
}
STREAM = ("--stream.seed", "9", "--stream.window", "4", "--stream.fresh", "0.25")


def start(name: str, data: Path, run: Path, *more: str) -> subprocess.Popen:
    words = ["train", name, "--data", str(data), "--out", str(run), *COMMON, *METHODS[name], *more]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-m", "warehouse_sim", *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment, text=True)


def finish(process: subprocess.Popen) -> None:
    _, said = process.communicate(timeout=900)
    assert process.returncode == 0, said


def checkpoints(run: Path) -> list[str]:
    return sorted(path.name for path in (run / "checkpoints").glob("step=*.safetensors"))


def weights(run: Path) -> dict[str, torch.Tensor]:
    return safetensors.torch.load_file(run / "weights.safetensors")


def killed_and_resumed(name: str, data: Path, folder: Path, *more: str) -> int:
    """Compare a training that is killed at its first checkpoint with one that is not; return its workers' number."""
    whole, part = folder / "whole", folder / "part"
    finish(start(name, data, whole, *more))
    killed = start(name, data, part, *more)
    while not checkpoints(part) and killed.poll() is None:
        time.sleep(0.005)
    started = descendants(killed.pid)
    workers = scene_workers(killed.pid)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert killed.returncode == -signal.SIGKILL  # it was not done yet
    assert not (part / "weights.safetensors").exists()
    deadline = time.monotonic() + 20.0
    while any(map(is_alive, started)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_alive, started))
    finish(start(name, data, part, "--resume", *more))
    assert "resume" in (part / "train.log").read_text(encoding="utf-8")
    expected, found = weights(whole), weights(part)
    assert expected.keys() == found.keys()
    for key, value in expected.items():
        assert torch.equal(value, found[key]), key
    return len(workers)


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize("name", METHODS)
def test_a_killed_training_ends_with_the_same_weights(name: str, toy_root: Path, tmp_path: Path) -> None:
    killed_and_resumed(name, toy_root, tmp_path)


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize("name", METHODS)
def test_a_killed_training_on_a_stream_ends_with_the_same_weights(name: str, shared: Shared, tmp_path: Path) -> None:
    data, recipe = shared.dataset(shared.small, scenes=8, seed=0, formats=("bop",)), str(shared.small)
    assert killed_and_resumed(name, data, tmp_path, "--stream.recipe", recipe, *STREAM) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["part", "whole"]  # a stream stores nothing
    files = [{path.name for path in (tmp_path / run).iterdir()} for run in ("part", "whole")]
    assert files[0] == files[1]
