"""Take points for the object's only as far as its size allows: what a mask or a box holds may lie far behind it."""

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

_REACH = 1.05
"""Points lie within so many diameters of the middle of the object's points."""
_NEARLY = 0.6
"""A nearer slab of depth is preferred that holds so many times the points of the fullest."""
_STEP = 0.35
"""Where depth jumps by more than this fraction of the diameter another object begins; between the posts of a pallet it
jumps by less."""


def gate_points(
    points: Float[Tensor, "b n 3"], inside: Bool[Tensor, "b n"], diameter: Float[Tensor, " b"], least: int
) -> tuple[Bool[Tensor, "b n"], Float[Tensor, "b 3"]]:
    """Return which points may be the object's, and the median of those that the mask holds, too.

    Of the points in the mask, those between two depths one diameter apart are taken that are most, or nearly as many
    and nearer: what is seen behind an object is not what was detected. Of these, those without a step in depth from
    their median; then all points, in the mask or not, within a diameter of their median and in their range of depth.

    Args:
        points: Camera frame (m).
        inside: Which of them the mask holds.
        diameter: Of each object (m).
        least: Where fewer points of the mask would remain, all pass.
    """
    z, size = points[..., 2], diameter[:, None]
    order = z.masked_fill(~inside, torch.inf).sort(dim=1).values
    last = torch.searchsorted(order, order + size, right=True)
    count = (last - torch.arange(z.shape[1], device=z.device)).masked_fill(order.isinf(), 0)
    first = _best_start(order, count, size)
    low, high = _without_steps(order, first, first + size, _STEP * size)
    kept = inside & (z >= low) & (z <= high)
    middle = masked_median(points, kept)
    near = (points - middle[:, None]).norm(dim=-1) <= _REACH * size
    passes = near & (z >= low - _STEP * size) & (z <= high + _STEP * size)
    kept = kept & passes
    enough = kept.sum(dim=1, keepdim=True) >= least
    passes = torch.where(enough, passes & (kept | ~inside), torch.ones_like(passes))
    return passes, masked_median(points, inside & passes)


def masked_median(points: Float[Tensor, "b n 3"], mask: Bool[Tensor, "b n"]) -> Float[Tensor, "b 3"]:
    """Return the median along each axis of the points in a mask; of two in the middle the lower one."""
    order = points.masked_fill(~mask[..., None], torch.inf).sort(dim=1).values
    row = (mask.sum(dim=1) - 1).clamp(min=0) // 2
    return torch.gather(order, 1, row[:, None, None].expand(-1, 1, 3))[:, 0]


def _best_start(
    order: Float[Tensor, "b n"], count: Int[Tensor, "b n"], size: Float[Tensor, "b 1"]
) -> Float[Tensor, "b 1"]:
    """Return the depth at which the fullest of the nearest good slabs begins.

    Args:
        order: Sorted depths (m).
        count: Points between each depth and one ``size`` farther.
        size: Thickness of a slab (m).
    """
    good = count >= _NEARLY * count.amax(dim=1, keepdim=True)
    nearest = order.masked_fill(~good, torch.inf).amin(dim=1, keepdim=True)
    # The slab that is good first may hold but a part of the object.
    local = count.masked_fill((order < nearest) | (order > nearest + size), 0)
    return torch.gather(order, 1, local.argmax(dim=1, keepdim=True))


def _without_steps(
    order: Float[Tensor, "b n"], low: Float[Tensor, "b 1"], high: Float[Tensor, "b 1"], step: Float[Tensor, "b 1"]
) -> tuple[Float[Tensor, "b 1"], Float[Tensor, "b 1"]]:
    """Return the range of sorted depths about the median of those between two limits that no step interrupts."""
    within = (order >= low) & (order <= high)
    first = (order < low).sum(dim=1, keepdim=True)
    median = (first + (within.sum(dim=1, keepdim=True) - 1) // 2).clamp(min=0)
    jumps = torch.diff(order, dim=1, prepend=order[:, :1]) > step
    piece = (jumps & within).cumsum(dim=1)
    same = within & (piece == torch.gather(piece, 1, median))
    return (
        order.masked_fill(~same, torch.inf).amin(dim=1, keepdim=True),
        order.masked_fill(~same, -torch.inf).amax(dim=1, keepdim=True),
    )
