from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.loop import Task, fit
from warehouse_sim.learning.parallel import Worker
from warehouse_sim.learning.settings import LoopConfig


class Line(Task):
    """Fit a line through the origin; what it is worth can only be told of finite weights."""

    def __init__(self, slope: float) -> None:
        super().__init__(nn.Linear(1, 1, bias=False))
        self.slope = slope

    def forward(self, index, part, step, fraction):
        x = torch.arange(1.0, 5.0)[:, None]
        return (self.network(x) - self.slope * x).square().mean()

    def validate(self, network):
        np.linalg.eigvalsh(np.full((2, 2), network.weight.item()))
        return {"off": abs(network.weight.item() - self.slope)}


class EveryStep:
    def indices(self, step):
        return torch.arange(4)


def run(slope: float, folder: Path) -> float:
    config = LoopConfig(max_minutes=None, max_steps=400, batch=4, learning_rate=0.05, ema=0.0, validations=2)
    task = Line(slope)
    fit(task, EveryStep(), config, Clock(400, None), folder, Worker(), [])
    return task.network.weight.item()


def test_the_loop_finds_the_slope(tmp_path: Path) -> None:
    assert run(0.7, tmp_path) == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize("slope", [float("inf"), float("nan"), 1e30])
def test_a_training_that_diverges_is_an_error_that_names_the_remedy(slope: float, tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match=r"step \d+ the network gives no finite numbers .* below 0\.05"):
        run(slope, tmp_path)
    assert not list(tmp_path.glob("**/*.safetensors"))
