"""What training of a segmenter minimises: cross entropy and overlap of masks, cross entropy of key points' places."""

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

_SPREAD_PX = 1.5
"""Of the place that a key point is requested."""


def mask_loss(logits: Float[Tensor, "b h w"], gt: Float[Tensor, "b h w"]) -> Float[Tensor, ""]:
    """Return binary cross entropy and 1 - Dice (Milletari et al., "V-Net", 3DV 2016)."""
    cross = functional.binary_cross_entropy_with_logits(logits, gt)
    chance = torch.sigmoid(logits)
    shared = (chance * gt).sum(dim=(1, 2))
    dice = 2.0 * shared / (chance.sum(dim=(1, 2)) + gt.sum(dim=(1, 2))).clamp(min=1.0)
    return cross + (1.0 - dice).mean()


def keypoint_loss(logits: Float[Tensor, "b k h w"], points: Float[Tensor, "b k 3"]) -> Float[Tensor, ""]:
    """Return the cross entropy of a map over all places with a narrow peak at the ground truth, of visible points."""
    _, _, height, width = logits.shape
    rows = torch.arange(height, device=logits.device, dtype=logits.dtype)
    columns = torch.arange(width, device=logits.device, dtype=logits.dtype)
    across = -((columns - points[..., :1]) ** 2) / (2 * _SPREAD_PX**2)
    down = -((rows - points[..., 1:2]) ** 2) / (2 * _SPREAD_PX**2)
    wanted = torch.softmax((down[..., :, None] + across[..., None, :]).flatten(2), dim=2)
    cross = -(wanted * torch.log_softmax(logits.flatten(2), dim=2)).sum(dim=2)
    there = points[..., 2]
    return (cross * there).sum() / there.sum().clamp(min=1.0)
