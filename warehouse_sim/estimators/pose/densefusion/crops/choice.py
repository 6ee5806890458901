"""Choose the points of crops with surroundings: disturb the mask, gate by size, mix in some around it."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.crops.augment import Noise, hide_points
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropTable
from warehouse_sim.estimators.pose.densefusion.crops.gate import gate_points
from warehouse_sim.estimators.pose.densefusion.crops.given_mask import Labelled, disturbed_masks
from warehouse_sim.estimators.pose.densefusion.crops.view import pixels_in, seen_crops, view_about
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig

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
        enough = (shown & known.belongs).sum(dim=1, keepdim=True) >= augment.min_points
        known = known._replace(present=torch.where(enough, shown, known.present))
        inside = disturbed_masks(known, noise.mask, augment.masks, augment.min_points)
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
    room, present = rows.points.shape[1], rows.point_count[:, None]
    few = room if augment is None else min(room, _LOOKED_AT * count)
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
        number = kept.clamp(min=augment.min_points).minimum(number)
    others = around.sum(dim=1, keepdim=True)
    step = torch.arange(count, device=inside.device)[None]
    is_other = ((step % _AROUND_EVERY) == _AROUND_EVERY - 1) & (others > 0)
    other = step // _AROUND_EVERY
    own = torch.where(others > 0, step - (step + 1) // _AROUND_EVERY, step)
    # Sorted by membership alone, their random order stays.
    order, other_order = ((~mask).to(torch.uint8).argsort(dim=1, stable=True) for mask in (inside, around))
    taken = torch.gather(order, 1, own % number)
    return torch.where(is_other, torch.gather(other_order, 1, other % others.clamp(min=1)), taken)
