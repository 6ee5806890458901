from pathlib import Path

import pytest
import torch
from torch import nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.loop import Task, fit
from warehouse_sim.learning.observer import Observer, TrainingState
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.settings import LoopConfig

CONFIG = LoopConfig(max_minutes=None, max_steps=12, batch=4, validations=4, precision="32")


class Line(Task):
    """Fit a line through a network that drops values at random, as no family here must."""

    def __init__(self) -> None:
        torch.manual_seed(7)
        super().__init__(nn.Sequential(nn.Linear(1, 8), nn.BatchNorm1d(8), nn.Dropout(0.5), nn.Linear(8, 1)))
        self.x = torch.linspace(-1, 1, 20)[:, None]

    def forward(self, index: torch.Tensor, part: slice, step: int, fraction: float) -> torch.Tensor:
        x = self.x[index[part]]
        return (self.network(x) - 2 * x).square().mean()

    def validate(self, network: nn.Module) -> dict[str, float]:
        assert not network.training
        return {"error": float((network(self.x) - 2 * self.x).abs().mean())}


class Killed(Observer):
    def on_step(self, state: TrainingState) -> None:
        if state.step == 8:
            raise KeyboardInterrupt


def trained(run: Path, *observers: Observer) -> tuple[Line, TrainingState]:
    task = Line()
    run.mkdir(exist_ok=True)
    return task, fit(task, SampleOrder(20, 4, 3), CONFIG, Clock(12, None), run, observers=observers)


def test_a_resumed_run_ends_as_one_that_was_not_interrupted_though_layers_draw_at_random(tmp_path: Path) -> None:
    whole, state = trained(tmp_path / "whole")
    with pytest.raises(KeyboardInterrupt):
        trained(tmp_path / "run", Killed())
    assert [path.name for path in (tmp_path / "run" / "checkpoints").iterdir()] == ["step=6.safetensors"]
    resumed, end = trained(tmp_path / "run")
    assert (end.step, end.stretch, end.metrics) == (state.step, state.stretch, state.metrics)
    for name, value in whole.network.state_dict().items():
        assert torch.equal(resumed.network.state_dict()[name], value), name


def test_a_run_that_was_over_only_says_so_again(tmp_path: Path) -> None:
    first, state = trained(tmp_path / "run")
    again, end = trained(tmp_path / "run", Killed())
    assert (end.step, end.loss, end.metrics) == (12, state.loss, state.metrics)
    assert all(torch.equal(a, b) for a, b in zip(first.parameters(), again.parameters(), strict=True))


def test_a_checkpoint_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "run" / "checkpoints"
    folder.mkdir(parents=True)
    (folder / "epoch=1-step=8.ckpt").write_bytes(b"pickled")
    with pytest.raises(TrainingError, match=r"step=8\.ckpt was written by an older version .* train again"):
        trained(tmp_path / "run")
    (folder / "step=3.safetensors").write_bytes(b"\0" * 40)
    with pytest.raises(TrainingError, match=r"step=3\.safetensors cannot be gone on from"):
        trained(tmp_path / "run")
