"""Disturb training samples so that few images teach much: hidden parts, turned clouds, changed colours.

Turning the cloud about its centre is the same as turning the camera: the visible surface stays the true one.
"""

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from warehouse_sim.learning.rotations import matrix_from_vector
from warehouse_sim.learning.settings import AugmentConfig


def random_turns(
    count: int, config: AugmentConfig, generator: torch.Generator, device: torch.device
) -> Float[Tensor, "b 3 3"]:
    """Return random rotations in the camera frame (x right, y down, z forward)."""
    sigma = torch.tensor([config.tilt, config.yaw, config.tilt], device=device)
    return matrix_from_vector(torch.randn((count, 3), generator=generator, device=device) * sigma)


def hide_points(
    points: Float[Tensor, "b p 3"],
    border_px: UInt8[Tensor, "b p"],
    present: Bool[Tensor, "b p"],
    config: AugmentConfig,
    generator: torch.Generator,
) -> Bool[Tensor, "b p"]:
    """Return which points remain after a random occluder, an eroded mask and random dropout.

    Args:
        points: Camera frame (m).
        border_px: Distance of each point's pixel to the mask's border.
        present: Which rows hold a point.
        config: How much is hidden.
        generator: Source of randomness.
    """
    batch, device = len(points), points.device
    draw = torch.rand((batch, 5), generator=generator, device=device)
    eroded = present & (border_px > (draw[:, :1] * (config.erode_px + 1)).floor())
    present = _unless_too_few(eroded, present, config.min_points)
    angle = draw[:, 1:2] * 2.0 * torch.pi
    image = points[..., :2] / points[..., 2:].clamp(min=1e-3)
    along = image[..., 0] * angle.cos() + image[..., 1] * angle.sin()
    low = along.masked_fill(~present, torch.inf).amin(dim=1, keepdim=True)
    high = along.masked_fill(~present, -torch.inf).amax(dim=1, keepdim=True)
    beyond = along > low + (high - low) * draw[:, 2:3] * config.hide_share
    present = _unless_too_few(present & (beyond | (draw[:, 3:4] > config.hide_probability)), present, config.min_points)
    dropped = torch.rand(present.shape, generator=generator, device=device) < draw[:, 4:5] * config.drop_share
    return _unless_too_few(present & ~dropped, present, config.min_points)


def disturb_colour(
    rgb: UInt8[Tensor, "b s s 3"], config: AugmentConfig, generator: torch.Generator
) -> UInt8[Tensor, "b s s 3"]:
    """Return crops with random brightness, contrast and white balance."""
    change = torch.rand((len(rgb), 1, 1, 5), generator=generator, device=rgb.device) * 2.0 - 1.0
    change = change * config.colour
    gain = (1.0 + change[..., :1]) * (1.0 + change[..., 2:] / 2.0)
    values = rgb.float()
    mean = values.mean(dim=(1, 2), keepdim=True)
    return (((values - mean) * (1.0 + change[..., 1:2]) + mean) * gain).clamp(0.0, 255.0).to(torch.uint8)


def _unless_too_few(fewer: Bool[Tensor, "b p"], before: Bool[Tensor, "b p"], least: int) -> Bool[Tensor, "b p"]:
    enough = fewer.sum(dim=1, keepdim=True) >= least
    return torch.where(enough, fewer, before)
