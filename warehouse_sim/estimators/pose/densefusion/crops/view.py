"""The part of a kept square crop that the network sees: about the points that count, not about all that is kept."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropTable


class View(NamedTuple):
    """A square part of each window."""

    corner: Float[Tensor, "b 2"]
    """Outer upper left corner (image pixels) from that of the window."""
    side: Float[Tensor, " b"]
    """Image pixels."""


def view_about(uv: Float[Tensor, "b n 2"], counts: Bool[Tensor, "b n"], margin: float) -> View:
    """Return the square about the box of those points that count.

    Args:
        uv: Column and row of each point's pixel.
        counts: Which points count, at least one of each sample.
        margin: Space around the box as a fraction of its longer side.
    """
    low = uv.masked_fill(~counts[..., None], torch.inf).amin(dim=1)
    high = uv.masked_fill(~counts[..., None], -torch.inf).amax(dim=1) + 1.0
    side = (high - low).amax(dim=1) * (1.0 + 2.0 * margin)
    return View((low + high - side[:, None]) / 2.0, side)


def pixels_in(view: View, uv: Float[Tensor, "b n 2"], side_px: int) -> Int[Tensor, "b n"]:
    """Return the row-major index of the crop pixel of each point; of points beyond the view, the nearest one's."""
    place = ((uv + 0.5 - view.corner[:, None]) * (side_px / view.side[:, None, None])).floor().long()
    column, row = place.clamp(0, side_px - 1).unbind(dim=-1)
    return row * side_px + column


def seen_crops(rows: CropTable, view: View, side_px: int) -> CropTable:
    """Return the rows with the square crops of the view in place of the kept ones.

    Readings and colours are taken from the nearest kept pixel; beyond the kept window there is none.
    """
    kept = rows.depth if rows.depth is not None else rows.rgb
    if kept is None:
        return rows
    assert rows.window_px is not None
    kept_px = kept.shape[1]
    scale = kept_px / rows.window_px
    step, first = view.side / side_px * scale, view.corner * scale[:, None]
    centre = first[..., None] + step[:, None, None] * (torch.arange(side_px, device=first.device) + 0.5)
    column, row = centre.floor().long().unbind(dim=1)
    outside = ((column < 0) | (column >= kept_px))[:, None] | ((row < 0) | (row >= kept_px))[..., None]
    index = row.clamp(0, kept_px - 1)[..., None] * kept_px + column.clamp(0, kept_px - 1)[:, None]
    found = rows
    if rows.depth is not None:
        depth = torch.gather(rows.depth.flatten(1), 1, index.flatten(1)).view_as(index)
        found = found._replace(depth=depth.masked_fill(outside, torch.nan))
    if rows.rgb is not None:
        rgb = torch.gather(rows.rgb.flatten(1, 2), 1, index.flatten(1)[..., None].expand(-1, -1, 3))
        found = found._replace(rgb=rgb.view(*index.shape, 3).masked_fill(outside[..., None], 0))
    if rows.ray_map is not None:
        found = found._replace(ray_map=_rays_of(rows.ray_map, step, first))
    return found


def _rays_of(
    ray_map: Float[Tensor, "b 2 3"], step: Float[Tensor, " b"], first: Float[Tensor, "b 2"]
) -> Float[Tensor, "b 2 3"]:
    # A kept pixel's centre is at its index: centre j of the view is at first + (j + 1/2) step - 1/2.
    offset = first + step[:, None] / 2.0 - 0.5
    shifted = ray_map[..., 2] + (ray_map[..., :2] @ offset[..., None])[..., 0]
    return torch.cat([ray_map[..., :2] * step[:, None, None], shifted[..., None]], dim=-1)
