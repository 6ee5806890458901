"""Draw network inputs from a crop set: choose points, disturb them, centre and scale them."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int, UInt8
from torch import Tensor

from warehouse_sim.learning.augment import disturb_colour, hide_points, random_turns
from warehouse_sim.learning.crop_set import CropSet
from warehouse_sim.learning.settings import AugmentConfig


class Batch(NamedTuple):
    """Inputs and true poses in normalised units: about ``centre``, in multiples of ``scale``, turned by ``turn``."""

    points: Float[Tensor, "b n 3"]
    pixel: Int[Tensor, "b n"]
    rgb: UInt8[Tensor, "b s s 3"] | None
    class_index: Int[Tensor, " b"]
    rotation: Float[Tensor, "b 3 3"]
    """True rotation."""
    translation: Float[Tensor, "b 3"]
    """True object origin, normalised."""
    centre: Float[Tensor, "b 3"]
    """Camera frame (m)."""
    scale: Float[Tensor, " b"]
    """Half the object's diameter (m)."""


def draw_batch(
    crops: CropSet,
    index: Int[Tensor, " b"],
    count: int,
    generator: torch.Generator,
    augment: AugmentConfig | None = None,
) -> Batch:
    """Return ``count`` random points of each of the crops ``index``.

    Args:
        crops: All crops.
        index: Which of them.
        count: Points of each; a crop with fewer repeats them.
        generator: Decides which points, and how they are disturbed.
        augment: How training samples are disturbed; None leaves them as measured.
    """
    points, present = crops.points[index], _present(crops, index)
    if augment:
        present = hide_points(points, crops.border_px[index], present, augment, generator)
    order = _random_order(present, count, generator)
    points = torch.gather(points, 1, order[..., None].expand(-1, -1, 3))
    scale = crops.diameter[index] / 2.0
    centre = points.median(dim=1).values
    if augment:
        shift = torch.rand(centre.shape, generator=generator, device=centre.device) * 2.0 - 1.0
        centre = centre + shift * augment.shift
    T = crops.T_camera_object[index]
    translation = ((T[:, :3, 3] - centre.double()) / scale[:, None]).float()
    points, rotation = (points - centre[:, None]) / scale[:, None, None], T[:, :3, :3].float()
    rgb = None if crops.rgb is None else crops.rgb[index]
    if augment:
        turn = random_turns(len(index), augment, generator, centre.device)
        points, rotation = points @ turn.mT, turn @ rotation
        translation = (turn @ translation[..., None])[..., 0]
        rgb = None if rgb is None else disturb_colour(rgb, augment, generator)
    pixel = torch.gather(crops.pixel[index].long(), 1, order)
    return Batch(points, pixel, rgb, crops.class_index[index], rotation, translation, centre, scale)


def _present(crops: CropSet, index: Int[Tensor, " b"]) -> Bool[Tensor, "b p"]:
    rows = torch.arange(crops.points.shape[1], device=crops.points.device)
    return rows < crops.point_count[index, None]


def _random_order(present: Bool[Tensor, "b p"], count: int, generator: torch.Generator) -> Int[Tensor, "b n"]:
    keys = torch.rand(present.shape, generator=generator, device=present.device).masked_fill(~present, -1.0)
    order = keys.topk(min(count, keys.shape[1]), dim=1).indices
    # Crops with fewer points than asked for start again from their first.
    wrapped = torch.arange(count, device=present.device) % present.sum(dim=1, keepdim=True)
    return torch.gather(order, 1, wrapped)
