"""A training whose process is killed goes on to the weights of one that was left alone, bit for bit."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import safetensors.torch
import torch

from tests.processes import descendants, is_alive

pytestmark = pytest.mark.slow

COMMON = ("--max-minutes", "None", "--max-steps", "60", "--validations", "6", "--precision", "32", "--threads", "1")
METHODS = {
    "densefusion-pointcloud": ("--batch", "4", "--cache", "none"),
    "detector-depth": ("--batch", "2", "--cache", "none", "--workers", "2"),
    "segmenter-depth": ("--batch", "2", "--cache", "none", "--workers", "2"),
}


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


@pytest.mark.parametrize("name", METHODS)
def test_a_killed_training_ends_with_the_same_weights(name: str, toy_root: Path, tmp_path: Path) -> None:
    whole, part = tmp_path / "whole", tmp_path / "part"
    finish(start(name, toy_root, whole))
    killed = start(name, toy_root, part)
    while not checkpoints(part) and killed.poll() is None:
        time.sleep(0.005)
    started = descendants(killed.pid)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert killed.returncode == -signal.SIGKILL  # it was not done yet
    assert not (part / "weights.safetensors").exists()
    deadline = time.monotonic() + 20.0
    while any(map(is_alive, started)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_alive, started))
    finish(start(name, toy_root, part, "--resume"))
    assert "resume" in (part / "train.log").read_text(encoding="utf-8")
    expected, found = weights(whole), weights(part)
    assert expected.keys() == found.keys()
    for key, value in expected.items():
        assert torch.equal(value, found[key]), key
