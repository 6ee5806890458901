import pytest
import torch

from warehouse_sim.estimators.pose.densefusion.networks.points import rectified_average_and_max


@pytest.mark.parametrize("count", [64, 37])
def test_values_and_gradient_are_those_of_torch(count: int) -> None:
    torch.manual_seed(0)
    deep = torch.randn(3, count, 8, dtype=torch.double)
    deep[0, :, 0] = -1.0  # a channel that no point has
    wanted = torch.randn(3, 16, dtype=torch.double)
    values, gradients = [], []
    for ours in (True, False):
        x = deep.clone().requires_grad_()
        hidden = torch.relu(x)
        plain = torch.cat([hidden.mean(dim=1), hidden.amax(dim=1)], dim=-1)
        values.append(rectified_average_and_max(x) if ours else plain)
        (values[-1] * wanted).sum().backward()
        gradients.append(x.grad)
    torch.testing.assert_close(values[0], values[1])
    torch.testing.assert_close(gradients[0], gradients[1])
    with torch.inference_mode():
        torch.testing.assert_close(rectified_average_and_max(deep), values[1])


def test_input_is_left_as_it_is() -> None:
    deep = torch.randn(2, 16, 4, requires_grad=True)
    before = deep.detach().clone()
    rectified_average_and_max(deep)
    assert torch.equal(deep, before)
