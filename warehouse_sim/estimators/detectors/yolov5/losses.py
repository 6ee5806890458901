"""What training of a detector minimises: complete IoU of boxes, objectness, classes."""

import math

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from warehouse_sim.estimators.detectors.yolov5.anchors import Assigned, Targets, assign, ignored
from warehouse_sim.estimators.detectors.yolov5.network import STRIDES, CellNetwork, Raw
from warehouse_sim.learning.compute import on_device

_BOX_WEIGHT, _CLASS_WEIGHT = 0.05, 0.5
"""Of 1 - CIoU and of telling classes apart, beside 1 for objectness: gains of the original."""
_LEVEL_WEIGHTS = (4.0, 1.0, 0.4)
"""Of objectness: the finest level has most cells."""


def complete_iou(a: Float[Tensor, "n 4"], b: Float[Tensor, "n 4"]) -> Float[Tensor, " n"]:
    """Return CIoU of boxes of edges, -1.5 to 1: overlap, distance of centres, shape.

    Zheng et al., "Distance-IoU loss", AAAI 2020, equations 8 to 11.
    """
    shared = (torch.minimum(a[:, 2:], b[:, 2:]) - torch.maximum(a[:, :2], b[:, :2])).clamp(min=0).prod(dim=1)
    size_a, size_b = (a[:, 2:] - a[:, :2]).clamp(min=1e-6), (b[:, 2:] - b[:, :2]).clamp(min=1e-6)
    iou = shared / (size_a.prod(dim=1) + size_b.prod(dim=1) - shared)
    around = torch.maximum(a[:, 2:], b[:, 2:]) - torch.minimum(a[:, :2], b[:, :2])
    apart = ((a[:, :2] + a[:, 2:] - b[:, :2] - b[:, 2:]) / 2).pow(2).sum(dim=1) / around.pow(2).sum(dim=1)
    angle_a, angle_b = torch.atan(size_a[:, 0] / size_a[:, 1]), torch.atan(size_b[:, 0] / size_b[:, 1])
    shape = (2.0 / math.pi * (angle_a - angle_b)) ** 2
    with torch.no_grad():
        weight = shape / (1.0 - iou + shape + 1e-6)
    return iou - apart - weight * shape


def detection_loss(network: CellNetwork, raw: Raw, targets: Targets) -> Float[Tensor, ""]:
    """Return the weighted sum of the three losses over all levels.

    ``targets`` are on the CPU, wherever the network computes: what learns is chosen there, as a GPU would have to be
    waited for at each choice.
    """
    stride = STRIDES[0]
    size_hw = raw.maps[0].shape[2] * stride, raw.maps[0].shape[3] * stride
    total = raw.maps[0].new_zeros((), dtype=torch.float32)
    anchors = torch.tensor(network.config.anchors, dtype=torch.float32).view(len(STRIDES), -1, 2)
    for level, found in enumerate(assign(targets, anchors, size_hw)):
        logits = raw.maps[level].float()
        total = total + _level_loss(network, logits, level, found, targets)
    return total


def _level_loss(
    network: CellNetwork,
    logits: Float[Tensor, "b a h w o"],
    level: int,
    found: Assigned,
    targets: Targets,
) -> Float[Tensor, ""]:
    device = logits.device
    box, kind = on_device(targets.boxes[found.target], device), targets.class_index[found.target]
    found = found.to(device)
    at = found.image, found.anchor, found.row, found.column
    gt = logits.new_zeros(logits.shape[:4])
    loss = logits.sum() * 0.0
    if len(found.target):
        centre, size = _placed(network, logits[at][:, :4], level, found)
        iou = complete_iou(torch.cat([centre - size / 2, centre + size / 2], dim=1), box)
        loss = loss + _BOX_WEIGHT * (1.0 - iou).mean()
        # Where two boxes share a cell and an anchor, the better fit says how sure it may be.
        gt.view(-1).scatter_reduce_(0, _flat(found, gt), iou.detach().clamp(min=0).to(gt.dtype), "amax")
        if network.config.classes > 1:
            wanted = on_device(functional.one_hot(kind, network.config.classes).to(logits.dtype), device)
            loss = loss + _CLASS_WEIGHT * functional.binary_cross_entropy_with_logits(logits[at][:, 5:], wanted)
    batch, _, height, width = gt.shape
    requested = on_device(~ignored(targets, (batch, height, width), STRIDES[level]), device)
    counts = requested[:, None] | (gt > 0)
    objectness = functional.binary_cross_entropy_with_logits(logits[..., 4], gt, reduction="none")
    return loss + _LEVEL_WEIGHTS[level] * (objectness * counts).mean()


def _placed(
    network: CellNetwork, logits: Float[Tensor, "n 4"], level: int, found: Assigned
) -> tuple[Float[Tensor, "n 2"], Float[Tensor, "n 2"]]:
    """Return centre and size (px) of single cells, as ``CellNetwork.place`` does of whole maps."""
    fraction = torch.sigmoid(logits)
    cell = torch.stack([found.column, found.row], dim=1)
    centre = (2.0 * fraction[:, :2] - 0.5 + cell) * STRIDES[level]
    return centre, (2.0 * fraction[:, 2:]) ** 2 * network.anchors[level][found.anchor]


def _flat(found: Assigned, shape: Float[Tensor, "b a h w"]) -> Tensor:
    _, anchors, height, width = shape.shape
    return ((found.image * anchors + found.anchor) * height + found.row) * width + found.column
