"""What is minimised, against the library's function and by hand."""

from dataclasses import replace
from importlib import import_module

import pytest
import torch

from tests.estimators.detectors.rtdetr.conftest import IMAGES, SMALLEST
from warehouse_sim.estimators.detectors.rtdetr import loss as module
from warehouse_sim.estimators.detectors.rtdetr.loss import covered, make_loss
from warehouse_sim.estimators.detectors.rtdetr.network import Found, RtdetrNetwork
from warehouse_sim.estimators.detectors.rtdetr.train import as_labels
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets

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
