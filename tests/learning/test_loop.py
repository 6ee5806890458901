from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning import clock as module
from warehouse_sim.learning.clock import Clock, learning_rate_factor
from warehouse_sim.learning.compute import cpu_threads, fold_normalisations, shapes_only
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


@pytest.fixture
def now(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    time = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: time[0])
    return time


def test_steps_alone_decide_without_a_time_limit() -> None:
    clock = Clock(200, None)
    assert [clock.fraction(step) for step in (0, 50, 200, 300)] == [0.0, 0.25, 1.0, 1.0]


def test_training_ends_in_time_for_the_last_validation(now: list[float]) -> None:
    clock = Clock(None, 60.0)
    now[0] += 10.0  # reading
    clock.reserve(5.0)
    clock.start_training()
    assert clock.fraction(0) == 0.0
    now[0] += 22.5
    assert clock.fraction(1) == pytest.approx(0.5)
    now[0] += 22.5
    assert clock.fraction(2) == 1.0
    assert clock.spent() == 55.0


def test_earlier_sessions_count(now: list[float]) -> None:
    first = Clock(None, 100.0)
    now[0] += 20.0
    first.start_training()
    now[0] += 40.0
    state = first.state()
    now[0] += 1000.0  # switched off
    second = Clock(None, 100.0)
    second.continue_from(state)
    second.start_training()
    assert second.spent() == 60.0
    assert second.fraction(0) == pytest.approx(0.5)


def test_reading_that_takes_all_the_time_ends_the_run(now: list[float]) -> None:
    clock = Clock(None, 5.0)
    now[0] += 6.0
    clock.start_training()
    assert clock.fraction(0) == 1.0


def test_learning_rate_rises_then_falls_to_a_hundredth() -> None:
    assert learning_rate_factor(0.0, 0, 10) == pytest.approx(0.1)
    assert learning_rate_factor(0.0, 9, 10) == pytest.approx(1.0)
    assert learning_rate_factor(0.5, 50, 10) == pytest.approx(0.505)
    assert learning_rate_factor(1.0, 99, 10) == pytest.approx(0.01)


def test_a_run_of_few_steps_is_not_all_warm_up() -> None:
    assert learning_rate_factor(0.1, 5, 100) == pytest.approx(0.976, abs=1e-3)
    assert learning_rate_factor(0.05, 2, 100) < 0.5


def test_an_agreed_share_of_the_time_overrules_the_own_clock(now: list[float]) -> None:
    clock = Clock(100, 60.0)
    clock.start_training()
    now[0] += 30.0
    assert clock.fraction(0) == pytest.approx(0.5)
    clock.agree(0.25)
    assert clock.fraction(0) == 0.25
    assert clock.fraction_of_time() == pytest.approx(0.5)
    assert clock.fraction(40) == 0.4


def made() -> nn.Module:
    return nn.ModuleList([
        nn.Conv2d(3, 8, 3), nn.BatchNorm2d(8), nn.Linear(8, 5), nn.LayerNorm(5), nn.Embedding(4, 5),
        nn.MultiheadAttention(8, 2), nn.PReLU(),
    ])  # fmt: skip


def test_shapes_are_those_of_the_network_and_no_value_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    real = {name: value.shape for name, value in made().state_dict().items()}

    def reject(tensor: Tensor, *_: object, **__: object) -> Tensor:
        raise AssertionError("a value is drawn")

    monkeypatch.setattr(torch.Tensor, "normal_", reject)
    with pytest.raises(AssertionError, match="a value is drawn"):
        made()
    with shapes_only():
        network = made()
    assert {name: value.shape for name, value in network.state_dict().items()} == real
    assert {value.device.type for value in network.state_dict().values()} == {"meta"}


def test_unit_matrices_have_their_shape() -> None:
    with shapes_only():
        shapes = [torch.eye(3).repeat(4, 1, 1).shape, torch.eye(2, 5).shape]
    assert shapes == [(4, 3, 3), (2, 5)]


def test_networks_made_afterwards_have_values() -> None:
    with shapes_only():
        nn.Embedding(4, 5)
    torch.manual_seed(0)
    weight = nn.Embedding(4, 5).weight
    assert weight.device.type == "cpu"
    assert float(weight.detach().std()) > 0.1


def test_folded_normalisations_give_what_they_gave() -> None:
    torch.manual_seed(0)
    inner = nn.Sequential(nn.Conv2d(3, 5, 3, stride=2, bias=False), nn.BatchNorm2d(5), nn.SiLU())
    network = nn.Sequential(inner, nn.Conv2d(5, 4, 1), nn.BatchNorm2d(4), nn.BatchNorm2d(4))
    images = torch.randn(8, 3, 9, 9)
    for part in network.modules():
        if isinstance(part, nn.BatchNorm2d):
            nn.init.uniform_(part.weight, 0.5, 2.0)
            nn.init.normal_(part.bias)
    network(3.0 * images + 1.0)
    expected = network.eval()(images)
    fold_normalisations(network)
    torch.testing.assert_close(network(images), expected, rtol=1e-5, atol=1e-5)
    assert [type(part) for part in network.modules()].count(nn.BatchNorm2d) == 1


def test_threads_are_given_back() -> None:
    before = torch.get_num_threads()
    with cpu_threads(3):
        assert torch.get_num_threads() == 3
    assert torch.get_num_threads() == before
