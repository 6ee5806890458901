"""Which points of kept crops a network sees: gates, the view about them, and their choice."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.crops.augment import (
    LEAST_POINTS,
    Labelled,
    Noise,
    disturbed_masks,
    hide_points,
)
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropTable
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig, CropConfig

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


_LOOKED_AT = 4
"""In training so many times the wanted points are looked at, drawn afresh each time; sorting them all would take as
long as the network."""
_AROUND_EVERY = 4
"""Each so manyth point is one that the mask does not hold, where there are any."""
_LEAST = 8
_NEVER_ERODED = 255


class Choice(NamedTuple):
    """N points of each of b crops."""

    rows: CropTable
    """The crops, their square crops being those that the network sees."""
    points: Float[Tensor, "b n 3"]
    """Camera frame (m)."""
    centre: Float[Tensor, "b 3"]
    """Median of the points that the mask holds (m)."""
    pixel: Int[Tensor, "b n"]
    """Row-major index into the square crop that the network sees."""
    inside: Float[Tensor, "b n"] | None = None
    """1 where the mask holds the point, else 0; none where it holds them all."""
    belongs: Bool[Tensor, "b n"] | None = None
    """Whether it is truly the object's; none where all are."""


def choose_with_surroundings(
    rows: CropTable, count: int, noise: Noise | None, augment: AugmentConfig | None, crop: CropConfig
) -> Choice:
    """Return ``count`` points of each crop, most of them in the mask.

    Args:
        rows: Crops with surroundings.
        count: Points of each.
        noise: Random numbers; without them the first points are taken under the mask as it is.
        augment: How training samples are disturbed; None leaves them as measured.
        crop: How they were cut.
    """
    points, known = _candidates(rows, count, noise, augment)
    if noise is not None and augment is not None and noise.mask is not None:
        shown = hide_points(
            points, torch.full_like(known.present, _NEVER_ERODED, dtype=torch.uint8), known.present, noise.hide, augment
        )
        # Nothing is hidden that leaves too little of the object itself.
        enough = (shown & known.belongs).sum(dim=1, keepdim=True) >= LEAST_POINTS
        known = known._replace(present=torch.where(enough, shown, known.present))
        inside = disturbed_masks(known, noise.mask, augment.masks.fraction)
    else:
        inside = (known.signed_px > 0) & known.present
    inside = torch.where(inside.any(dim=1, keepdim=True), inside, known.present)
    passes, centre = gate_points(points, inside, rows.diameter, _LEAST)
    inside = inside & passes
    chosen = _mixed(inside, known.present & passes & ~inside, count, noise, augment)
    view, pixel = view_about(known.uv, inside, crop.margin), torch.zeros_like(chosen)
    if crop.side_px:
        pixel = pixels_in(view, torch.gather(known.uv, 1, chosen[..., None].expand(-1, -1, 2)), crop.side_px)
        rows = seen_crops(rows, view, crop.side_px)
    return Choice(
        rows,
        torch.gather(points, 1, chosen[..., None].expand(-1, -1, 3)),
        centre,
        pixel,
        torch.gather(inside, 1, chosen).float(),
        torch.gather(known.belongs, 1, chosen),
    )


def _candidates(
    rows: CropTable, count: int, noise: Noise | None, augment: AugmentConfig | None
) -> tuple[Float[Tensor, "b k 3"], Labelled]:
    """Return the points that are looked at: in training a stretch of those that are kept, which are in random order."""
    around = rows.signed_px, rows.belongs, rows.neighbour, rows.uv, rows.window_px, rows.outline
    signed_px, belongs, neighbour, uv, window_px, outline = (item for item in around if item is not None)
    capacity, present = rows.points.shape[1], rows.point_count[:, None]
    few = capacity if augment is None else min(capacity, _LOOKED_AT * count)
    steps = torch.arange(few, device=rows.points.device)[None]
    start = 0 if noise is None else (noise.choice[:, :1] * present).long()
    place = (start + steps) % present
    pairs = place[..., None]
    known = Labelled(
        torch.gather(signed_px, 1, place).float(),
        torch.gather(belongs, 1, place),
        torch.gather(neighbour, 1, place).float(),
        torch.gather(uv, 1, pairs.expand(-1, -1, 2)).float(),
        window_px,
        outline.float(),
        steps < present,
    )
    return torch.gather(rows.points, 1, pairs.expand(-1, -1, 3)), known


def _mixed(
    inside: Bool[Tensor, "b k"],
    around: Bool[Tensor, "b k"],
    count: int,
    noise: Noise | None,
    augment: AugmentConfig | None,
) -> Int[Tensor, "b n"]:
    """Return which of the points are taken: those in the mask, and now and then one around it."""
    number = inside.sum(dim=1, keepdim=True)
    if noise is not None and augment is not None:
        kept = (number * (1.0 - noise.choice[:, 1:] * augment.drop_fraction)).long()
        number = kept.clamp(min=LEAST_POINTS).minimum(number)
    others = around.sum(dim=1, keepdim=True)
    step = torch.arange(count, device=inside.device)[None]
    is_other = ((step % _AROUND_EVERY) == _AROUND_EVERY - 1) & (others > 0)
    other = step // _AROUND_EVERY
    own = torch.where(others > 0, step - (step + 1) // _AROUND_EVERY, step)
    # Sorted by membership alone, their random order stays.
    order, other_order = ((~mask).to(torch.uint8).argsort(dim=1, stable=True) for mask in (inside, around))
    taken = torch.gather(order, 1, own % number)
    return torch.where(is_other, torch.gather(other_order, 1, other % others.clamp(min=1)), taken)
