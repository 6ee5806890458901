import json
import operator
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import safetensors.torch
import torch

from tests.processes import left_after_kill
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.preparation import prepare
from warehouse_sim.estimators.pose.densefusion.training.train import task_and_order
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.estimators.train import train
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.compute import cpu_threads
from warehouse_sim.learning.loop import fit
from warehouse_sim.learning.parallel import Worker, start_workers
from warehouse_sim.learning.run_folder import write_weights

CONFIG = TrainConfig(
    max_minutes=None, max_steps=4, batch=4, validations=2, precision="32", threads=1, refiner_start=0.5
)
NAME = "densefusion-pointcloud"


def fit_and_keep(worker: Worker, data: Path, folder: Path, config: TrainConfig) -> None:
    """Train as one of several processes and write what this one has in the end."""
    with cpu_threads(config.threads):
        prepared = prepare(ESTIMATORS.get(NAME), [data], config, None, None)
        torch.manual_seed(worker.rank)
        network = DenseFusion(prepared.config.network, len(prepared.config.objects))
        clock = Clock(config.max_steps, None if config.max_minutes is None else 60 * config.max_minutes)
        fit(*task_and_order(prepared, network), config, clock, folder / "run", worker)
    own = folder / str(worker.rank)
    own.mkdir(parents=True)
    write_weights(own, network)


def weights(folder: Path) -> dict[str, torch.Tensor]:
    return safetensors.torch.load_file(folder / "weights.safetensors")


def test_two_processes_learn_what_one_learns(toy_root: Path, tmp_path: Path) -> None:
    fit_and_keep(Worker(), toy_root, tmp_path / "alone", CONFIG)
    with start_workers(2, fit_and_keep, toy_root, tmp_path / "both", CONFIG) as worker:
        fit_and_keep(worker, toy_root, tmp_path / "both", CONFIG)
    assert not torch.distributed.is_initialized()
    alone, first, second = (weights(tmp_path / name) for name in ("alone/0", "both/0", "both/1"))
    torch.manual_seed(0)
    start = DenseFusion(ESTIMATORS.get(NAME).network("nano"), 1).state_dict()
    for name, value in first.items():
        assert torch.equal(value, second[name]), name
        # Gradients are summed in another order, and Adam divides by their size: where one is next to nothing, noise
        # decides. That must not show beside what was learnt.
        assert (value - alone[name]).norm() <= 1e-3 * (alone[name] - start[name]).norm(), name


@pytest.mark.slow
def test_a_time_limit_ends_both_at_the_same_step(toy_root: Path, tmp_path: Path) -> None:
    config = replace(CONFIG, max_steps=None, max_minutes=30 / 60, devices=2)
    run = train(NAME, toy_root, tmp_path / "run", config)
    result = json.loads((run / "result.json").read_text())
    assert result["devices"] == 2
    assert result["samples"] == 4 * result["steps"] > 0
    assert result["seconds"] < 43.0


def test_a_process_that_fails_is_told() -> None:
    # What no worker can be made an index of fails in a process that imports nothing of this file.
    with pytest.raises(TrainingError, match="process of the training failed"), start_workers(2, operator.index):
        pass


ORPHAN = """
import time
from warehouse_sim.learning.parallel import start_workers
def wait(place):
    time.sleep(600)
if __name__ == "__main__":
    with start_workers(2, wait):
        print("started", flush=True)
        time.sleep(600)
"""


def test_companions_end_with_a_process_that_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "orphan.py"
    script.write_text(ORPHAN)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, env=environment)
    assert process.stdout is not None
    assert process.stdout.readline() == b"started\n"
    assert left_after_kill(process, 30.0) == set()


def test_a_batch_must_be_divisible() -> None:
    with pytest.raises(ConfigError, match="batch 16 cannot be shared evenly by 3 devices"):
        TrainConfig(devices=3)
    assert Worker(1, 4).fraction == slice(1, None, 4)
