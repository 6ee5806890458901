"""Which cells and anchors learn which box.

An anchor learns a box whose width and height differ from its own by less than a factor of four, at the cell of the
box's centre and at the two cells that are next nearest, in every level that has such an anchor.
"""

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from warehouse_sim.estimators.detectors.yolov5.anchors import FITS
from warehouse_sim.estimators.detectors.yolov5.network import STRIDES
from warehouse_sim.learning.compute import on_device


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
