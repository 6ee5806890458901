"""The library's network between our channels and our boxes."""

import pytest
import torch

from tests.estimators.detectors.rtdetr.conftest import IMAGES, SMALLEST
from warehouse_sim.estimators.detectors.rtdetr.network import (
    SIZES,
    Found,
    RtdetrNetwork,
    RtdetrNetworkConfig,
    make_detr,
)
from warehouse_sim.estimators.images.settings import ImageConfig


@pytest.mark.parametrize(("size", "published"), [("r18", 20), ("r34", 31)])
def test_sizes_are_the_published_ones(size: str, published: int) -> None:
    # Zhao et al., CVPR 2024, table 2 and its code: millions of weights with COCO's 80 classes.
    network = make_detr(RtdetrNetworkConfig(**SIZES[size], classes=80), 3)
    assert int(sum(item.numel() for item in network.parameters()) / 1e6) == published


def test_boxes_are_edges_on_the_canvas() -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES)
    logits = torch.zeros(1, 1, 3)
    boxes = torch.tensor([[[0.5, 0.25, 0.2, 0.5]]])
    found, scores = network.decode(Found(((logits, boxes),), (logits, boxes), (200, 100)))
    torch.testing.assert_close(found, torch.tensor([[[80.0, 0.0, 120.0, 50.0]]]))
    assert scores.tolist() == [[[0.5, 0.5, 0.5]]]


@pytest.mark.parametrize("reads", [("rgb",), ("depth",), ("rgb", "depth")])
def test_images_of_any_canvas_pass_with_what_is_read(reads: tuple[str, ...]) -> None:
    network = RtdetrNetwork(SMALLEST, ImageConfig(reads)).eval()
    for height, width in ((64, 96), (32, 160)):
        rgb = torch.randint(0, 256, (2, height, width, 3), dtype=torch.uint8) if "rgb" in reads else None
        depth = torch.rand(2, height, width) if "depth" in reads else None
        with torch.inference_mode():
            boxes, scores = network.decode(network(rgb, depth))
        assert (boxes.shape, scores.shape) == ((2, 20, 4), (2, 20, 3))
        assert torch.isfinite(boxes).all()


def test_signals_pass_a_fresh_network_and_its_first_boxes_are_the_anchors() -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES)
    scales = [item.weight for item in network.modules() if isinstance(item, torch.nn.BatchNorm2d)]
    assert scales
    assert all(bool((scale == 1).all()) for scale in scales)
    with torch.no_grad():
        found = network.eval()(torch.randint(0, 256, (1, 64, 96, 3), dtype=torch.uint8), None)
    # The anchors of the finest level are squares of a twentieth of the canvas, of the next twice as large.
    sizes = found.layers[-1][1][0, :, 2:]
    nearest = (sizes[:, :1] - torch.tensor([0.05, 0.1, 0.2])).abs().amin(dim=1)
    assert float(nearest.max()) < 1e-4
    torch.testing.assert_close(sizes[:, 0], sizes[:, 1])


def test_arithmetic_stays_in_32_bits_within_autocast() -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES).eval()
    rgb = torch.randint(0, 256, (1, 64, 96, 3), dtype=torch.uint8)
    with torch.no_grad():
        plain = network.decode(network(rgb, None))[0]
        with torch.autocast("cpu", dtype=torch.bfloat16):
            mixed = network.decode(network(rgb, None))[0]
    torch.testing.assert_close(mixed, plain)
