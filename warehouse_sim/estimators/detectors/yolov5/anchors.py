"""Anchors for the boxes of a dataset, and which cells and anchors learn which box."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from warehouse_sim.estimators.detectors.yolov5.network import STRIDES
from warehouse_sim.learning.compute import on_device

FITS = 4.0
"""An anchor is assigned boxes whose width and height differ from its own by less than this factor."""
_ROUNDS = 50


class AnchorFit(NamedTuple):
    """Anchors, and how well they fit."""

    anchors_wh: Float[np.ndarray, "a 2"]
    """Width and height (px), by area."""
    recall: float
    """Fraction of the boxes that some anchor fits, 0-1."""


def cluster_anchors(boxes_wh: Float[np.ndarray, "k 2"], count: int, rng: np.random.Generator) -> AnchorFit:
    """Return anchors by K-means over the logarithms of widths and heights: what counts are ratios.

    Args:
        boxes_wh: Sizes of at least one box (px).
        count: Number of anchors.
        rng: Samples the first centres (Arthur & Vassilvitskii, "k-means++", SODA 2007).
    """
    points = np.log(np.maximum(np.asarray(boxes_wh, dtype=float), 1.0))
    centres = _first_centres(points, count, rng)
    for _ in range(_ROUNDS):
        nearest = ((points[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
        moved = np.array([
            points[nearest == i].mean(axis=0) if (nearest == i).any() else centres[i] for i in range(count)
        ])  # fmt: skip
        if np.allclose(moved, centres):
            break
        centres = moved
    anchors = np.exp(centres)
    anchors = anchors[anchors.prod(axis=1).argsort(kind="stable")]
    return AnchorFit(anchors, anchor_recall(boxes_wh, anchors))


def anchor_recall(boxes_wh: Float[np.ndarray, "k 2"], anchors_wh: Float[np.ndarray, "a 2"]) -> float:
    """Return the fraction of boxes that some anchor fits."""
    ratio = np.maximum(boxes_wh, 1.0)[:, None] / anchors_wh
    worst = np.maximum(ratio, 1.0 / ratio).max(axis=2)
    return float((worst.min(axis=1) < FITS).mean())


def _first_centres(points: Float[np.ndarray, "k 2"], count: int, rng: np.random.Generator) -> Float[np.ndarray, "c 2"]:
    centres = [points[rng.integers(len(points))]]
    while len(centres) < count:
        distance = ((points[:, None] - np.array(centres)) ** 2).sum(axis=2).min(axis=1)
        total = distance.sum()
        # Fewer different boxes than anchors: the rest are spread about one of them.
        chosen = rng.choice(len(points), p=distance / total) if total > 0 else rng.integers(len(points))
        centres.append(points[chosen] + (0.0 if total > 0 else rng.normal(0.0, 0.2, 2)))
    return np.array(centres)


@dataclass(frozen=True, eq=False)
class Targets:
    """Ground-truth boxes of a batch."""

    image: Int[Tensor, " k"]
    """Of the batch."""
    boxes: Float[Tensor, "k 4"]
    """Edges on the canvas (px)."""
    class_index: Int[Tensor, " k"]
    wanted: Bool[Tensor, " k"]
    """Whether they are to be found; of others nothing is learnt, neither that they are there nor that they are not."""


@dataclass(frozen=True, eq=False)
class Assigned:
    """What learns in one level."""

    image: Int[Tensor, " n"]
    anchor: Int[Tensor, " n"]
    row: Int[Tensor, " n"]
    column: Int[Tensor, " n"]
    target: Int[Tensor, " n"]
    """Which box."""

    def to(self, device: torch.device) -> "Assigned":
        """Return the same on a device."""
        fields = self.image, self.anchor, self.row, self.column, self.target
        return Assigned(*(on_device(field, device) for field in fields))


def assign(targets: Targets, anchors: Float[Tensor, "l a 2"], size_hw: tuple[int, int]) -> list[Assigned]:
    """Return what learns in each level, for a canvas of ``size_hw`` (px)."""
    return [_assign_level(targets, anchors[level], stride, size_hw) for level, stride in enumerate(STRIDES)]


def _assign_level(targets: Targets, anchors: Float[Tensor, "a 2"], stride: int, size_hw: tuple[int, int]) -> Assigned:
    size = (targets.boxes[:, 2:] - targets.boxes[:, :2]).clamp(min=0.1)
    ratio = size[None] / anchors[:, None]
    fits = torch.maximum(ratio, 1.0 / ratio).amax(dim=2) < FITS
    anchor, target = (fits & targets.wanted).nonzero(as_tuple=True)
    centre = (targets.boxes[target, :2] + targets.boxes[target, 2:]) / (2 * stride)
    last = torch.tensor([size_hw[1] // stride, size_hw[0] // stride], device=centre.device) - 1
    cell = torch.minimum(centre.floor().long().clamp(min=0), last)
    # The neighbours on the sides where the centre lies in the cell.
    side = torch.where(centre - cell < 0.5, -1, 1)
    along_u, along_v = torch.zeros_like(cell), torch.zeros_like(cell)
    along_u[:, 0], along_v[:, 1] = side[:, 0], side[:, 1]
    cells = torch.cat([cell, cell + along_u, cell + along_v])
    inside = ((cells >= 0) & (cells <= last)).all(dim=1)
    anchor, target, cells = anchor.repeat(3)[inside], target.repeat(3)[inside], cells[inside]
    return Assigned(targets.image[target], anchor, cells[:, 1], cells[:, 0], target)


def ignored(targets: Targets, shape: tuple[int, ...], stride: int) -> Bool[Tensor, "b h w"]:
    """Return the cells of a level (b h w) whose centres lie in a box of which nothing is learnt."""
    batch, height, width = shape
    ignored = ~targets.wanted
    edges = (targets.boxes[ignored] / stride).trunc()
    image, device = targets.image[ignored], targets.boxes.device
    columns, rows = torch.arange(width, device=device), torch.arange(height, device=device)
    across = (columns >= edges[:, :1]) & (columns < edges[:, 2:3] + 1)
    down = (rows >= edges[:, 1:2]) & (rows < edges[:, 3:] + 1)
    covered = (down[:, :, None] & across[:, None, :]).flatten(1).to(torch.int32)
    count = torch.zeros((batch, height * width), dtype=torch.int32, device=device)
    return count.index_add(0, image, covered).view(shape) > 0
