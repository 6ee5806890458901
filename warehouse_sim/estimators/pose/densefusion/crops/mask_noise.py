"""Disturb the masks of training samples: what a detector or a segmenter might have given in their place.

Each point of a crop knows how far its pixel is from the outline, so that other outlines are a matter of comparing.
"""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.settings import MaskNoiseConfig

_WAVES = 3
_WAVELENGTH_PX = 9.0, 70.0
_HOLE_FRACTION = 0.15, 0.5
_LEAST_KEPT = 0.5
"""Of a mask that is cut, so much of its extent remains."""
_MOST_NEIGHBOURS = 16
_COLUMNS = {"whether": 8, "grow": 1, "wander": 1 + 3 * _WAVES, "shift": 2, "hole": 4, "cut": 2,
            "merge": _MOST_NEIGHBOURS, "box": 4}  # fmt: skip
NOISE_WIDTH = sum(_COLUMNS.values())
"""Uniform random numbers that a sample needs."""


class Labelled(NamedTuple):
    """N points of each of b crops, and what is known of them."""

    signed_px: Float[Tensor, "b n"]
    """Pixels to the true outline, positive inside."""
    belongs: Bool[Tensor, "b n"]
    neighbour: Float[Tensor, "b n"]
    uv: Float[Tensor, "b n 2"]
    """Column and row from the window's upper left pixel (px)."""
    window_px: Float[Tensor, " b"]
    outline: Float[Tensor, "b o o"]
    """Pixels to the true outline over the window."""
    present: Bool[Tensor, "b n"]


def disturbed_masks(
    known: Labelled, noise: Float[Tensor, "b k"], config: MaskNoiseConfig, least: int
) -> Bool[Tensor, "b n"]:
    """Return which points a disturbed mask holds.

    Args:
        known: The points.
        noise: Uniform random numbers, 0-1.
        config: How often and how much.
        least: A mask that would hold fewer points stays the true one.
    """
    gt_mask = (known.signed_px > 0) & known.present
    part = dict(zip(_COLUMNS, noise.split(tuple(_COLUMNS.values()), dim=1), strict=True))
    odds = [
        config.fraction,
        config.grow,
        config.wander,
        config.shift,
        config.hole,
        config.cut,
        config.merge,
        config.box,
    ]
    does = part["whether"] < torch.tensor(odds, device=noise.device)
    disturbed, grow, wander, shift, hole, cut, merge, box = (item[:, None] for item in does.unbind(dim=1))
    # Between a pixel inside and one outside lies the outline, half a pixel from both.
    distance = known.signed_px - 0.5 * known.signed_px.sign()
    distance = distance + grow * (2.0 * part["grow"] - 1.0) * (config.max_px + 0.5)
    distance = distance + wander * _waves(known, part["wander"], config.max_px)
    distance = distance + shift * _shifted(known, (2.0 * part["shift"] - 1.0) * config.max_px)
    mask = distance > 0
    mask = mask | (merge & _neighbours(known, part["merge"]))
    mask = torch.where(box, _box(known, part["box"], config.box_error), mask)
    mask = mask & ~(hole & _hole(known, part["hole"])) & ~(cut & _cut_off(known, part["cut"]))
    mask = mask & known.present
    keeps = disturbed & (mask.sum(dim=1, keepdim=True) >= least)
    return torch.where(keeps, mask, gt_mask)


def _waves(known: Labelled, noise: Tensor, max_px: float) -> Float[Tensor, "b n"]:
    """Return a field (px) of a few plane waves that is nowhere larger than ``max_px``."""
    strength, angle, phase, length = noise.split((1, _WAVES, _WAVES, _WAVES), dim=1)
    low, high = _WAVELENGTH_PX
    turn, wavelength = 2.0 * torch.pi * angle, low * (high / low) ** length
    along = known.uv @ torch.stack([turn.cos(), turn.sin()], dim=1)
    waves = (2.0 * torch.pi * (along / wavelength[:, None] + phase[:, None])).sin()
    return strength * max_px * waves.mean(dim=-1)


def _shifted(known: Labelled, shift_px: Float[Tensor, "b 2"]) -> Float[Tensor, "b n"]:
    """Return by how much (px) the distance to the outline changes at each point when the mask is shifted."""
    scale = 2.0 / known.window_px[:, None, None]
    here = (known.uv + 0.5) * scale - 1.0
    there = (known.uv + 0.5 - shift_px[:, None]) * scale - 1.0
    values = torch.nn.functional.grid_sample(
        known.outline[:, None], torch.stack([here, there], dim=1), padding_mode="border", align_corners=False
    )
    return values[:, 0, 1] - values[:, 0, 0]


def _neighbours(known: Labelled, noise: Float[Tensor, "b m"]) -> Bool[Tensor, "b n"]:
    taken = noise < 0.5
    # Number 0 is no neighbour.
    taken = torch.cat([torch.zeros_like(taken[:, :1]), taken[:, 1:]], dim=1)
    return torch.gather(taken, 1, known.neighbour.long())


def _extent(known: Labelled) -> tuple[Float[Tensor, "b 2"], Float[Tensor, "b 2"]]:
    """Return the corners (px) of the box of the points that are the object's."""
    out = ~(known.belongs & known.present)[..., None]
    low = known.uv.masked_fill(out, torch.inf).amin(dim=1)
    return low, known.uv.masked_fill(out, -torch.inf).amax(dim=1)


def _box(known: Labelled, noise: Float[Tensor, "b 4"], error: float) -> Bool[Tensor, "b n"]:
    low, high = _extent(known)
    moved = (2.0 * noise - 1.0) * error * (high - low).amax(dim=1, keepdim=True)
    low, high = (low + moved[:, :2])[:, None], (high + moved[:, 2:])[:, None]
    return ((known.uv >= low) & (known.uv <= high)).all(dim=-1)


def _hole(known: Labelled, noise: Float[Tensor, "b 4"]) -> Bool[Tensor, "b n"]:
    low, high = _extent(known)
    size = high - low
    middle = low + noise[:, :2] * size
    least, most = _HOLE_FRACTION
    half = size * (least + (most - least) * noise[:, 2:]) / 2.0
    return ((known.uv - middle[:, None]).abs() <= half[:, None]).all(dim=-1)


def _cut_off(known: Labelled, noise: Float[Tensor, "b 2"]) -> Bool[Tensor, "b n"]:
    """Return the points beyond a straight line across the mask."""
    angle = 2.0 * torch.pi * noise[:, :1]
    along = known.uv[..., 0] * angle.cos() + known.uv[..., 1] * angle.sin()
    out = ~(known.belongs & known.present)
    low = along.masked_fill(out, torch.inf).amin(dim=1, keepdim=True)
    high = along.masked_fill(out, -torch.inf).amax(dim=1, keepdim=True)
    return along > low + (high - low) * (_LEAST_KEPT + (1.0 - _LEAST_KEPT) * noise[:, 1:])
