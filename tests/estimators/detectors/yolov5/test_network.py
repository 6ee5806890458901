import numpy as np
import pytest
import torch

from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.detectors.yolov5.network import DEPTH, WIDTHS, DetectorNetwork, DetectorNetworkConfig
from warehouse_sim.estimators.images.settings import ImageConfig


@pytest.mark.parametrize(("size", "published"), [("nano", 1_872_157), ("small", 7_235_389)])
def test_parameters_are_the_published_ones(size: str, published: int) -> None:
    """YOLOv5n and s of release 6 for the 80 classes of COCO, published as 1.9 and 7.2 million."""
    network = DetectorNetwork(DetectorNetworkConfig(WIDTHS[size], DEPTH, 80), ImageConfig(("rgb",)))
    assert sum(item.numel() for item in network.parameters()) == published


def test_boxes_of_zero_logits_are_the_anchors_about_the_cells() -> None:
    network = DetectorNetwork(DetectorNetworkConfig(width=0.05), ImageConfig()).eval()
    for head in network.heads:
        torch.nn.init.zeros_(head.weight)
        torch.nn.init.zeros_(head.bias)
    boxes, scores = network.decode(network(torch.zeros(1, 64, 96, 3, dtype=torch.uint8), None))
    assert boxes.shape == (1, 3 * (8 * 12 + 4 * 6 + 2 * 3), 4)
    assert torch.allclose(scores, torch.full_like(scores, 0.5))
    # The cell at row 2, column 5 of the finest level, second anchor (16, 30).
    found = boxes[0, 8 * 12 + 2 * 12 + 5].detach()
    np.testing.assert_allclose(found, [5.5 * 8 - 8, 2.5 * 8 - 15, 5.5 * 8 + 8, 2.5 * 8 + 15], atol=1e-4)


def test_anchors_must_serve_three_levels() -> None:
    with pytest.raises(ConfigError, match="multiple of 3"):
        DetectorNetworkConfig(anchors=((1.0, 1.0),) * 4)
