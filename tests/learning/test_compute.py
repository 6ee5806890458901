import pytest
import torch
from torch import Tensor, nn

from warehouse_sim.learning.compute import cpu_threads, shapes_only


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


def test_threads_are_given_back() -> None:
    before = torch.get_num_threads()
    with cpu_threads(3):
        assert torch.get_num_threads() == 3
    assert torch.get_num_threads() == before
