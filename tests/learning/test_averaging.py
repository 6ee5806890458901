import pytest
import torch
from torch import nn

from warehouse_sim.learning.checkpoint import MovingAverage


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
