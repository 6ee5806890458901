"""The library's network between our channels and our boxes."""

from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.estimators.detectors.rtdetr.conftest import IMAGES, SMALLEST
from warehouse_sim.cli.main import main
from warehouse_sim.estimators.detectors.rtdetr import train as module
from warehouse_sim.estimators.detectors.rtdetr.network import (
    SIZES,
    Found,
    RtdetrNetwork,
    RtdetrNetworkConfig,
    RtdetrRun,
    make_detr,
)
from warehouse_sim.estimators.detectors.rtdetr.train import as_labels, covered, make_loss
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets
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


# An RT-DETR as an ONNX file, run by onnxruntime on inputs that the export did not see.


@pytest.mark.slow
def test_the_file_gives_the_same_boxes(run: Path, tmp_path: Path) -> None:
    onnxruntime = pytest.importorskip("onnxruntime")
    assert main(["export", str(run), "--out", str(tmp_path / "m.onnx")]) == 0
    network = RtdetrRun.read(run).load_network(run)
    rgb = torch.randint(0, 256, (4, 64, 96, 3), dtype=torch.uint8)
    depth = 9 * torch.rand(4, 64, 96)
    session = onnxruntime.InferenceSession(str(tmp_path / "m.onnx"), providers=["CPUExecutionProvider"])
    boxes, scores = session.run(None, {"rgb": rgb.numpy(), "depth": depth.numpy()})
    with torch.no_grad():
        expected = network.decode(network(rgb, depth))
    np.testing.assert_allclose(boxes, expected[0], atol=5e-2)
    np.testing.assert_allclose(scores, expected[1], atol=1e-3)


# What is minimised, against the library's function and by hand.


TARGETS = Targets(
    torch.tensor([0, 0, 2]),
    torch.tensor([[10.0, 20.0, 30.0, 40.0], [0.0, 0.0, 96.0, 64.0], [48.0, 32.0, 96.0, 64.0]]),
    torch.tensor([1, 0, 2]),
    torch.tensor([True, False, True]),
)


def test_targets_become_centres_and_sizes_as_shares_of_the_canvas() -> None:
    first, second, third = as_labels(TARGETS, 3, (96, 64))
    torch.testing.assert_close(first["boxes"], torch.tensor([[20 / 96, 30 / 64, 20 / 96, 20 / 64]]))
    torch.testing.assert_close(first["ignored"], torch.tensor([[0.5, 0.5, 1.0, 1.0]]))
    assert [len(second[name]) for name in ("boxes", "ignored", "class_labels")] == [0, 0, 0]
    torch.testing.assert_close(third["boxes"], torch.tensor([[0.75, 0.75, 0.5, 0.5]]))
    assert (first["class_labels"].tolist(), third["class_labels"].tolist()) == ([1], [2])


def test_a_box_is_covered_where_half_of_it_lies_in_another() -> None:
    boxes = torch.tensor([[0.5, 0.5, 0.2, 0.2], [0.61, 0.5, 0.2, 0.2], [0.59, 0.5, 0.2, 0.2], [0.1, 0.1, 0.1, 0.1]])
    other = torch.tensor([[0.5, 0.5, 0.2, 1.0]])
    assert covered(boxes, other).tolist() == [True, False, True, False]
    assert covered(boxes, other[:0]).tolist() == [False] * 4


def random_output(queries: int = 6, denoised: int = 0, seed: int = 0) -> Found:
    generator = torch.Generator().manual_seed(seed)

    def pair(count: int) -> tuple[torch.Tensor, torch.Tensor]:
        boxes = 0.2 + 0.3 * torch.rand(2, count, 4, generator=generator)
        return torch.randn(2, count, 3, generator=generator).requires_grad_(), boxes

    return Found((pair(denoised + queries), pair(denoised + queries)), pair(queries), (96, 64))


def labels(*counts: int, ignored: int = 0) -> list[dict[str, torch.Tensor]]:
    generator = torch.Generator().manual_seed(9)
    return [
        {
            "class_labels": torch.randint(3, (count,), generator=generator),
            "boxes": 0.2 + 0.3 * torch.rand(count, 4, generator=generator),
            "ignored": torch.tensor([[0.5, 0.5, 1.0, 1.0]])[: min(1, ignored)],
        }
        for count in counts
    ]


def test_without_denoising_it_is_the_librarys_own(library) -> None:
    theirs_of = import_module("transformers.loss.loss_rt_detr").RTDetrForObjectDetectionLoss
    config = RtdetrNetwork(SMALLEST, IMAGES).model.config
    found, wanted = random_output(), labels(2, 3)
    logits, boxes = (torch.stack(part, dim=1) for part in zip(*found.layers, strict=True))
    theirs, _, _ = theirs_of(logits[:, -1], wanted, logits.device, boxes[:, -1], config, logits, boxes, *found.first)
    torch.testing.assert_close(make_loss(config)(found, wanted), theirs)


def test_boxes_to_be_denoised_take_no_targets_of_the_last_layer(library, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_WEIGHTS", {"loss_vfl": 0.0, "loss_bbox": 1.0, "loss_giou": 0.0})
    config = RtdetrNetwork(SMALLEST, IMAGES).model.config
    wanted = labels(1, 1)
    found = random_output(denoised=2)
    # Those to be denoised, one that is right and one that is wrong in each image, are as good as can be.
    for image, gt in enumerate(wanted):
        for _, boxes in found.layers:
            boxes[image, 0] = gt["boxes"][0]
    meta = {"dn_positive_idx": (torch.tensor([0]), torch.tensor([0])), "dn_num_group": 1, "dn_num_split": [2, 6]}
    loss = make_loss(config)
    with_them = loss(replace(found, denoising=meta), wanted)
    without = loss(replace(found, layers=tuple((a[:, 2:], b[:, 2:]) for a, b in found.layers)), wanted)
    torch.testing.assert_close(with_them, without)


@pytest.mark.parametrize("ignored", [0, 1])
def test_nothing_is_learnt_of_boxes_that_nobody_asks_for(library, ignored: int) -> None:
    config = RtdetrNetwork(SMALLEST, IMAGES).model.config
    found = random_output()
    make_loss(config)(found, labels(1, 0, ignored=ignored)).backward()
    logits = found.layers[-1][0].grad
    assert logits is not None
    learning = (logits.abs().amax(dim=2) > 1e-9).sum(dim=1).tolist()
    # The box that is matched learns all the same.
    assert learning == ([1, 0] if ignored else [6, 6])


def test_a_batch_without_any_target_teaches_that_there_is_nothing(library) -> None:
    config = RtdetrNetwork(SMALLEST, IMAGES).model.config
    found = random_output()
    loss = make_loss(config)(found, labels(0, 0))
    loss.backward()
    assert torch.isfinite(loss)
    assert all(bool((logits.grad > 0).all()) for logits, _ in (*found.layers, found.first))
