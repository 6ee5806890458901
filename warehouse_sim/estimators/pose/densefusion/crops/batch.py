"""Batches of crops: drawn, disturbed, levelled and normalised."""

from typing import NamedTuple, Protocol

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.crops.augment import (
    LEAST_POINTS,
    NOISE_WIDTH,
    Noise,
    disturb_colour,
    hide_points,
    random_turns,
    sample_noise,
)
from warehouse_sim.estimators.pose.densefusion.crops.choice import Choice, choose_with_surroundings
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropTable
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth, NetworkInput
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig, CropConfig

_LEAST_AHEAD = 0.05
"""A camera that looks so straight down or up (sine of the angle) has no heading; its image's upper border is ahead."""


def level_turns(down: Float[Tensor, "b 3"]) -> Float[Tensor, "b 3 3"]:
    """Return the rotations R_level_camera; the identity where gravity is unknown (NaN).

    The axes of the levelled camera are x right, y down (gravity), z ahead, horizontally: ``gravity.upright_frame``'s
    with the names that a camera gives them, so that a level camera is not turned at all.
    """
    known = ~down.isnan().any(dim=1, keepdim=True)
    level = torch.tensor([0.0, 1.0, 0.0], device=down.device).expand_as(down)
    y = torch.nn.functional.normalize(torch.where(known, down, level), dim=-1)
    forward, upward = (torch.tensor(axis, device=down.device) for axis in ([0.0, 0.0, 1.0], [0.0, -1.0, 0.0]))
    steep = y[:, :2].norm(dim=1, keepdim=True) < _LEAST_AHEAD
    ahead = torch.where(steep, upward, forward)
    z = torch.nn.functional.normalize(ahead - y * (ahead * y).sum(dim=1, keepdim=True), dim=-1)
    return torch.stack([torch.linalg.cross(y, z), y, z], dim=1)


def is_known(down: Float[Tensor, "b 3"]) -> Bool[Tensor, " b"]:
    """Return which of the directions are known."""
    return ~down.isnan().any(dim=1)


DEPTH_LIMIT = 3.0
"""Depth crops are clipped to so many half diameters before and behind the centre."""


class CropSource(Protocol):
    """What crops are drawn from, by their numbers."""

    def rows(self, index: Int[Tensor, " b"]) -> CropTable:
        """Return copies of the crops ``index``, in this order."""


class Batch(NamedTuple):
    """Inputs and true poses in normalised units: about ``centre``, in multiples of ``scale``."""

    inputs: NetworkInput
    rotation: Float[Tensor, "b 3 3"]
    """True rotation."""
    translation: Float[Tensor, "b 3"]
    """True object origin, normalised."""
    centre: Float[Tensor, "b 3"]
    """Camera frame (m)."""
    scale: Float[Tensor, " b"]
    """Half the object's diameter (m)."""

    turn: Float[Tensor, "b 3 3"] | None = None
    """Rotation from the camera's axes to those of the input; none where they are the same."""
    belongs: Bool[Tensor, "b n"] | None = None
    """Which points are truly the object's, where they need not be."""

    @property
    def gt(self) -> GroundTruth:
        """What the networks' losses compare with."""
        return GroundTruth(self.rotation, self.translation, self.inputs.class_index, self.belongs)


def sample_batch(
    crops: CropSource,
    index: Int[Tensor, " b"],
    count: int,
    generator: torch.Generator | None = None,
    augment: AugmentConfig | None = None,
    fraction: slice = slice(None),
    crop: CropConfig | None = None,
    upright: bool = False,
) -> Batch:
    """Return ``count`` random points of each of the crops ``index``, and their square crops.

    Args:
        crops: All crops.
        index: Which of them.
        count: Points of each; a crop with fewer repeats them.
        generator: Decides which points, and how they are disturbed; without it the first points are taken as measured.
        augment: How training samples are disturbed; None leaves them as measured.
        fraction: Which samples of the batch are wanted; each is disturbed as it is in the whole batch.
        crop: How the crops were cut, which must be given for those with surroundings.
        upright: Whether clouds are turned upright where gravity is known.
    """
    rows, noise = crops.rows(index[fraction]), None
    if generator is not None:
        mask_width = NOISE_WIDTH if rows.has_surroundings else 0
        noise = sample_noise(len(index), generator, mask_width, upright).rows(fraction)
    chosen = _choice(rows, count, noise, augment, crop)
    rows, points, centre = chosen.rows, chosen.points, chosen.centre
    scale = rows.diameter / 2.0
    if augment and noise:
        centre = centre + (noise.shift * 2.0 - 1.0) * augment.shift
    T = rows.T_camera_object
    translation = ((T[:, :3, 3] - centre.double()) / scale[:, None]).float()
    points, rotation = (points - centre[:, None]) / scale[:, None, None], T[:, :3, :3].float()
    turn, known = _turns(rows, noise, augment, upright)
    if turn is not None:
        points, rotation = points @ turn.mT, turn @ rotation
        translation = (turn @ translation[..., None])[..., 0]
    rgb = rows.rgb
    if augment and noise:
        rgb = None if rgb is None else disturb_colour(rgb, noise.colour, augment)
    depth = _normalised_depth(rows, centre, scale, turn)
    inputs = NetworkInput(points, chosen.pixel, rows.class_index, rgb, depth, chosen.inside, known)
    return Batch(inputs, rotation, translation, centre, scale, turn, chosen.belongs)


def _choice(
    rows: CropTable, count: int, noise: Noise | None, augment: AugmentConfig | None, crop: CropConfig | None
) -> Choice:
    if rows.has_surroundings:
        assert crop is not None, "crops with surroundings are drawn as they were cut"
        return choose_with_surroundings(rows, count, noise, augment, crop)
    order = _choose_points(rows, count, noise, augment)
    points = torch.gather(rows.points, 1, order[..., None].expand(-1, -1, 3))
    centre = points.mT.contiguous().median(dim=2).values
    pixel = torch.zeros_like(order) if rows.pixel is None else torch.gather(rows.pixel, 1, order).long()
    return Choice(rows, points, centre, pixel)


def _turns(
    rows: CropTable, noise: Noise | None, augment: AugmentConfig | None, upright: bool
) -> tuple[Float[Tensor, "b 3 3"] | None, Float[Tensor, " b"] | None]:
    """Return the rotations from the camera's axes to those of the input, and where they follow gravity."""
    turn, known, leaning = None, None, None
    if upright:
        assert rows.down is not None
        down = rows.down
        if augment and noise and noise.gravity is not None:
            down = down.masked_fill(noise.gravity < augment.gravity_drop, torch.nan)
            # One number decides both: what is left above the first share is even again.
            most = augment.gravity_drop + (1.0 - augment.gravity_drop) * augment.lean_fraction
            leaning = noise.gravity[:, 0] < most
        turn, known = level_turns(down), is_known(down)
    if augment and noise:
        random = random_turns(noise.turn, augment, known, leaning)
        turn = random if turn is None else random @ turn
    return turn, None if known is None else known.float()


def _choose_points(
    rows: CropTable, count: int, noise: Noise | None, augment: AugmentConfig | None
) -> Int[Tensor, "b n"]:
    """Return which of its points each sample takes."""
    steps, present = torch.arange(count, device=rows.points.device), rows.point_count[:, None]
    if noise is None:
        return steps % present
    # Points lie in random order: any stretch of those that remain, from any start, is a random choice.
    start, dropped = noise.choice.split(1, dim=1)
    if augment is None:
        return ((start * present).long() + steps % present) % present
    is_there = torch.arange(rows.points.shape[1], device=rows.points.device) < present
    remaining = hide_points(rows.points, rows.border_px, is_there, noise.hide, augment)
    present = remaining.sum(dim=1, keepdim=True)
    # Dropout at random only matters to a sample that is left with fewer points than it needs.
    kept = (present * (1.0 - dropped * augment.drop_fraction)).long()
    kept = kept.clamp(min=LEAST_POINTS).minimum(present)
    wanted = ((start * present).long() + steps % kept) % present
    places, first = remaining.nonzero()[:, 1], present.cumsum(dim=0) - present
    return places[first + wanted]


def _normalised_depth(
    rows: CropTable, centre: Float[Tensor, "b 3"], scale: Float[Tensor, " b"], turn: Float[Tensor, "b 3 3"] | None
) -> Float[Tensor, "b s s 2"] | None:
    """Return the depth crops of the turned camera about the centre, and where they hold a reading.

    The pixel with ray r and depth z shows the point z r, which a turn R about the centre c brings to the depth
    (R (z r - c))_z: with the third row of R, and r linear in the pixel, one product a pixel.
    """
    if rows.depth is None or rows.depth_base is None or rows.ray_map is None:
        return None
    forward = torch.tensor([[0.0, 0.0, 1.0]], device=centre.device) if turn is None else turn[:, 2]
    plane = torch.einsum("bi,bij->bj", forward[:, :2].expand(len(centre), 2), rows.ray_map)
    across = torch.arange(rows.depth.shape[-1], device=centre.device, dtype=torch.float32)
    factor = plane[:, 0, None, None] * across + plane[:, 1, None, None] * across[:, None]
    factor += (plane[:, 2] + forward[:, 2])[:, None, None]
    depth = rows.depth.float()
    offset = (forward * centre).sum(dim=1)
    ahead = ((depth + rows.depth_base[:, None, None]) * factor - offset[:, None, None]) / scale[:, None, None]
    reading = ~depth.isnan()
    ahead = ahead.clamp(-DEPTH_LIMIT, DEPTH_LIMIT).masked_fill(~reading, 0.0)
    return torch.stack([ahead, reading.float()], dim=1).permute(0, 2, 3, 1)
