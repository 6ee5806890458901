import pytest
import torch

from warehouse_sim.learning.methods import ESTIMATORS
from warehouse_sim.learning.networks.densefusion import DenseFusion

BATCH, CLASSES = 2, 3


def build(name: str, size: str) -> tuple[DenseFusion, dict]:
    torch.manual_seed(0)
    network = DenseFusion(ESTIMATORS.get(name).network(size), CLASSES)
    count, image = network.config.points.count, network.config.image
    side = image.side_px if image else 1
    inputs = {
        "points": torch.randn(BATCH, count, 3),
        "rgb": torch.randint(0, 256, (BATCH, side, side, 3), dtype=torch.uint8) if image else None,
        "pixel": torch.randint(0, side * side, (BATCH, count)),
        "class_index": torch.tensor([2, 0]),
    }
    return network, inputs


@pytest.mark.parametrize("name", ESTIMATORS.names())
@pytest.mark.parametrize("size", ["nano", "small", "full"])
def test_shapes(name: str, size: str) -> None:
    network, x = build(name, size)
    network.eval()
    with torch.inference_mode():
        colour = network.embed(x["rgb"], x["pixel"])
        quat, translation, logit = network(x["points"], colour, x["class_index"])
        rotation, shift = network.refine(
            torch.eye(3).expand(BATCH, 3, 3), torch.zeros(BATCH, 3), x["points"], colour, x["class_index"]
        )
    count = x["points"].shape[1]
    assert colour is None if network.config.image is None else colour.shape == (BATCH, count, 32)
    assert quat.shape == (BATCH, count, 4)
    assert translation.shape == (BATCH, count, 3)
    assert logit.shape == (BATCH, count)
    # An untrained refiner changes nothing.
    torch.testing.assert_close(rotation, torch.eye(3).expand(BATCH, 3, 3))
    torch.testing.assert_close(shift, torch.zeros(BATCH, 3))


@pytest.mark.parametrize("name", ESTIMATORS.names())
@pytest.mark.parametrize("size", ["nano", "small"])
def test_gradients_reach_every_parameter(name: str, size: str) -> None:
    network, x = build(name, size)
    # The refiner's last layer starts at zero, which would stop its gradients at the first step.
    torch.nn.init.normal_(network.refiner.output.weight, std=0.01)
    colour = network.embed(x["rgb"], x["pixel"])
    quat, translation, logit = network(x["points"], colour, x["class_index"])
    rotation, shift = network.refine(
        torch.eye(3).expand(BATCH, 3, 3), translation[:, 0], x["points"], colour, x["class_index"]
    )
    sum(value.square().sum() for value in (quat, translation, logit, rotation * 1.5 + 1, shift)).backward()
    dead = [name for name, value in network.named_parameters() if value.grad is None or not value.grad.any()]
    assert dead == []


@pytest.mark.parametrize("name", ESTIMATORS.names())
def test_each_object_is_answered_for_its_own_class(name: str) -> None:
    network, x = build(name, "nano")
    network.eval()
    with torch.inference_mode():
        colour = network.embed(x["rgb"], x["pixel"])
        mixed = network(x["points"], colour, torch.tensor([2, 0]))
        for index in (0, 2):
            alone = network(x["points"], colour, torch.full((BATCH,), index))
            row = 0 if index == 2 else 1
            for a, b in zip(mixed, alone, strict=True):
                torch.testing.assert_close(a[row], b[row])


def test_full_size_has_about_the_original_number_of_parameters() -> None:
    # 21.36 M and 1.92 M for one class in the original, less its dead classifier, plus batch normalisation and the
    # second pooling of the refiner.
    network = DenseFusion(ESTIMATORS.get("densefusion").network("full"), 1)
    millions = sum(value.numel() for value in network.parameters()) / 1e6
    assert millions == pytest.approx(23.2, abs=0.5)
