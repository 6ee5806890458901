import math

import pytest
import torch

from warehouse_sim.estimators.detectors.yolov5.anchors import Targets
from warehouse_sim.estimators.detectors.yolov5.losses import complete_iou, detection_loss
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorNetworkConfig
from warehouse_sim.estimators.images.settings import ImageConfig


def test_a_shifted_box_in_closed_form() -> None:
    """Shapes are equal, so that only overlap and distance count: 1/3 - (w/2)^2 / ((1.5 w)^2 + h^2)."""
    a, b = torch.tensor([[0.0, 0.0, 60.0, 12.0]]), torch.tensor([[30.0, 0.0, 90.0, 12.0]])
    assert complete_iou(a, b).item() == pytest.approx(1 / 3 - 900 / (8100 + 144), abs=1e-5)


def test_another_shape_about_the_same_centre_in_closed_form() -> None:
    a, b = torch.tensor([[-30.0, -6.0, 30.0, 6.0]]), torch.tensor([[-6.0, -30.0, 6.0, 30.0]])
    iou = 144 / (2 * 720 - 144)
    v = (2 / math.pi * (math.atan(5) - math.atan(0.2))) ** 2
    assert complete_iou(a, b).item() == pytest.approx(iou - v * v / (1 - iou + v), abs=1e-5)


@pytest.mark.parametrize("classes", [1, 3])
def test_descent_finds_the_box(classes: int) -> None:
    """Free logits in place of a network's: the loss alone must lead to the box, its class, and nothing else."""
    torch.manual_seed(0)
    network = DetectorNetwork(DetectorNetworkConfig(width=0.05, classes=classes), ImageConfig()).eval()
    raw = network(torch.zeros(1, 64, 96, 3, dtype=torch.uint8), None)
    maps = [torch.nn.Parameter(item.detach().clone()) for item in raw.maps]
    box = torch.tensor([[21.0, 9.0, 70.0, 31.0]])
    targets = Targets(torch.tensor([0]), box, torch.tensor([classes - 1]), torch.tensor([True]))
    optimiser = torch.optim.Adam(maps, lr=0.1)
    for _ in range(150):
        loss = detection_loss(network, type(raw)(tuple(maps)), targets)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    boxes, scores = network.decode(type(raw)(tuple(maps)))
    best = int(scores[0].amax(dim=1).argmax())
    torch.testing.assert_close(boxes[0, best].detach(), box[0], atol=1.0, rtol=0)
    assert int(scores[0, best].argmax()) == classes - 1
    sure = scores[0].amax(dim=1) > 0.5
    assert (boxes[0][sure].detach() - box[0]).abs().max() < 3.0
