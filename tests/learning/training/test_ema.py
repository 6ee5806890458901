from types import SimpleNamespace

import pytest
import torch
from torch import nn

from warehouse_sim.learning.training.ema import MovingAverage


def started(network: nn.Module, decay: float) -> MovingAverage:
    average = MovingAverage(network, decay)
    average.on_fit_start(None, None)
    return average


def step(average: MovingAverage, number: int) -> None:
    average.on_train_batch_end(SimpleNamespace(global_step=number), None)


def test_average_follows_the_recurrence_and_early_steps_count_more() -> None:
    network = nn.Linear(1, 1, bias=False)
    nn.init.constant_(network.weight, 0.0)
    average, expected = started(network, 0.9), 0.0
    for number in range(1, 200):
        nn.init.constant_(network.weight, float(number))
        step(average, number)
        decay = min(0.9, (1 + number) / (10 + number))
        expected = decay * expected + (1 - decay) * number
    average.apply()
    assert network.weight.item() == pytest.approx(expected, rel=1e-5)
    assert expected == pytest.approx(199 - 9, abs=0.1)


def test_validation_sees_the_average_and_training_goes_on_with_the_weights() -> None:
    network = nn.Sequential(nn.Linear(2, 3), nn.BatchNorm1d(3))
    average = started(network, 0.5)
    before = {name: value.clone() for name, value in network.state_dict().items()}
    for parameter in network.parameters():
        nn.init.normal_(parameter)
    network(torch.randn(8, 2))
    weights = {name: value.clone() for name, value in network.state_dict().items()}
    step(average, 1)
    average.on_validation_start(None, None)
    decay = 2 / 11
    for name, value in network.state_dict().items():
        if value.is_floating_point():
            torch.testing.assert_close(value, decay * before[name] + (1 - decay) * weights[name], msg=name)
        else:
            assert torch.equal(value, weights[name]), name
    average.on_validation_end(None, None)
    assert all(torch.equal(value, weights[name]) for name, value in network.state_dict().items())


def test_a_step_counts_once_and_a_later_session_goes_on() -> None:
    network = nn.Linear(4, 4)
    average = started(network, 0.9)
    for number in (1, 2, 2, 3):
        nn.init.normal_(network.weight)
        held = network.weight.clone()
        step(average, number)
    resumed = MovingAverage(network, 0.9)
    resumed.load_state_dict(average.state_dict())
    resumed.on_fit_start(None, None)
    nn.init.zeros_(network.weight)
    step(resumed, 3)
    resumed.apply()
    after = network.weight.clone()
    assert not torch.equal(after, held)
    average.apply()
    assert torch.equal(network.weight, after)


def test_without_decay_the_average_is_the_weights() -> None:
    network = nn.Linear(4, 4)
    average = started(network, 0.0)
    nn.init.normal_(network.weight)
    held = network.weight.clone()
    step(average, 1)
    nn.init.zeros_(network.weight)
    average.apply()
    assert torch.equal(network.weight, held)
