from pathlib import Path

import pytest
import torch
from torch import nn

from warehouse_sim.errors import OutputError, TrainingError
from warehouse_sim.learning.checkpoint import MovingAverage
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.loop import Task, fit
from warehouse_sim.learning.observer import Observer, TrainingState
from warehouse_sim.learning.records import EventFile
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
    (folder / "step=3.safetensors").write_bytes(b"\0" * 40)
    with pytest.raises(TrainingError, match=r"step=3\.safetensors cannot be gone on from"):
        trained(tmp_path / "run")


def test_average_follows_the_recurrence_and_early_steps_count_more() -> None:
    network = nn.Linear(1, 1, bias=False)
    nn.init.constant_(network.weight, 0.0)
    average, expected = MovingAverage(network, 0.9), 0.0
    for number in range(1, 200):
        nn.init.constant_(network.weight, float(number))
        average.follow(network, number)
        decay = min(0.9, (1 + number) / (10 + number))
        expected = decay * expected + (1 - decay) * number
    assert average.module.weight.item() == pytest.approx(expected, rel=1e-5)
    assert expected == pytest.approx(199 - 9, abs=0.1)


def test_buffers_are_averaged_and_counters_taken_over() -> None:
    network = nn.Sequential(nn.Linear(2, 3), nn.BatchNorm1d(3))
    average = MovingAverage(network, 0.5)
    before = {name: value.clone() for name, value in network.state_dict().items()}
    for parameter in network.parameters():
        nn.init.normal_(parameter)
    network(torch.randn(8, 2))
    weights = {name: value.clone() for name, value in network.state_dict().items()}
    average.follow(network, 1)
    decay = 2 / 11
    for name, value in average.module.state_dict().items():
        if value.is_floating_point():
            torch.testing.assert_close(value, decay * before[name] + (1 - decay) * weights[name], msg=name)
        else:
            assert torch.equal(value, weights[name]), name
    assert all(torch.equal(value, weights[name]) for name, value in network.state_dict().items())


def test_without_decay_the_average_is_the_weights() -> None:
    network = nn.Linear(4, 4)
    average = MovingAverage(network, 0.0)
    nn.init.normal_(network.weight)
    held = network.weight.clone()
    average.follow(network, 1)
    nn.init.zeros_(network.weight)
    assert torch.equal(average.module.weight, held)


def test_a_full_disk_is_told_at_once() -> None:
    """Where tensorboardX's own writer only tells the terminal, from a thread that ends."""
    with pytest.raises(OutputError, match=r"/dev/full: cannot be written \(No space left on device\)"):
        EventFile(Path("/dev/full"))


def test_a_file_is_readable_after_every_value(tmp_path: Path) -> None:
    file, sizes = EventFile(tmp_path / "events.out.tfevents.1"), []
    for step in range(3):
        file.write({"loss": float(step)}, step)
        sizes.append((tmp_path / "events.out.tfevents.1").stat().st_size)
    assert sizes[0] < sizes[1] < sizes[2]
