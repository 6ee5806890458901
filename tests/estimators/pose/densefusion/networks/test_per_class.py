import torch

from warehouse_sim.estimators.pose.densefusion.networks.per_class import PerClassLinear


def test_each_object_meets_its_classs_weights() -> None:
    torch.manual_seed(0)
    layer = PerClassLinear(5, 3, classes=4)
    x, index = torch.randn(3, 7, 5), torch.tensor([3, 0, 3])
    found = layer(x, index)
    for row, number in enumerate(index.tolist()):
        torch.testing.assert_close(found[row], x[row] @ layer.weight[number] + layer.bias[number])
    found.sum().backward()
    unseen = [1, 2]
    assert not layer.weight.grad[unseen].any()
    torch.testing.assert_close(layer.bias.grad[3], torch.full((3,), 14.0))


def test_stays_in_32_bits_under_mixed_precision() -> None:
    layer = PerClassLinear(5, 3, classes=2)
    x, index = torch.randn(2, 4, 5), torch.tensor([1, 0])
    with torch.autocast("cpu", torch.bfloat16):
        found = layer(x, index)
    assert torch.equal(found, layer(x, index))
