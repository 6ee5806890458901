"""Disturb training samples so that few images teach much: hidden parts, turned clouds, changed colours.

Turning the cloud about its centre is the same as turning the camera: the visible surface stays the true one.
"""

import math
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_vector
from warehouse_sim.estimators.pose.densefusion.settings import AugmentConfig


class Noise(NamedTuple):
    """Random numbers of a batch, a row a sample; uniform in 0-1 but for the turn."""

    choice: Float[Tensor, "b 2"]
    """Which points are taken and how many are dropped."""
    hide: Float[Tensor, "b 4"]
    """What is hidden."""
    shift: Float[Tensor, "b 3"]
    """How the centre is shifted."""
    colour: Float[Tensor, "b 5"]
    """How colours change."""
    turn: Float[Tensor, "b 3"]
    """How the camera is turned; standard normal."""
    mask: Float[Tensor, "b k"] | None = None
    """How the mask is disturbed, where crops hold what is around it."""
    gravity: Float[Tensor, "b 1"] | None = None
    """Whether gravity is given, where the network reads it."""

    def rows(self, fraction: slice) -> "Noise":
        """Return the numbers of some of the samples."""
        return Noise(*(None if values is None else values[fraction] for values in self))  # type: ignore[arg-type]


def sample_noise(count: int, generator: torch.Generator, mask_width: int = 0, gravity: bool = False) -> Noise:
    """Return the random numbers of ``count`` samples.

    Args:
        count: Number of samples.
        generator: Source.
        mask_width: Numbers for the mask of each; 0 for none.
        gravity: Whether there is one for gravity, too.
    """
    uniform = torch.rand((count, 14), generator=generator, device=generator.device)
    normal = torch.randn((count, 3), generator=generator, device=generator.device)
    choice, hide, shift, colour = uniform.split((2, 4, 3, 5), dim=1)
    # Drawn last: what needs neither has the same numbers as before.
    wanted = {"mask": mask_width, "gravity": int(gravity)}
    more = {
        name: torch.rand((count, width), generator=generator, device=generator.device) if width else None
        for name, width in wanted.items()
    }
    return Noise(choice, hide, shift, colour, normal, **more)


def random_turns(
    noise: Float[Tensor, "b 3"],
    config: AugmentConfig,
    upright: Bool[Tensor, " b"] | None = None,
    leaning: Bool[Tensor, " b"] | None = None,
) -> Float[Tensor, "b 3 3"]:
    """Return random rotations in the camera frame (x right, y down, z forward).

    Args:
        noise: Standard normal numbers.
        config: How strong they are.
        upright: Which samples stand upright by their gravity, and are tilted by its error alone; none by default.
        leaning: Which of these lean against gravity; none by default.
    """
    turns = noise * torch.tensor([config.tilt, config.yaw, config.tilt], device=noise.device)
    if upright is not None:
        error, lean = math.radians(config.gravity_error_deg), math.radians(config.lean_deg)
        slight = noise * torch.tensor([error, config.yaw, error], device=noise.device)
        if leaning is not None:
            much = noise * torch.tensor([lean, config.yaw, lean], device=noise.device)
            slight = torch.where(leaning[:, None], much, slight)
        turns = torch.where(upright[:, None], slight, turns)
    return matrix_from_vector(turns)


def hide_points(
    points: Float[Tensor, "b p 3"],
    border_px: UInt8[Tensor, "b p"],
    present: Bool[Tensor, "b p"],
    noise: Float[Tensor, "b 4"],
    config: AugmentConfig,
) -> Bool[Tensor, "b p"]:
    """Return which points remain after an eroded mask and a random occluder.

    Args:
        points: Camera frame (m).
        border_px: Distance of each point's pixel to the mask's border.
        present: Which rows hold a point.
        noise: Uniform random numbers.
        config: How much is hidden.
    """
    taken_px = (noise[:, :1] * (config.erode_px + 1)).to(torch.uint8)
    present = _unless_too_few(present & (border_px > taken_px), present, config.min_points)
    angle = noise[:, 1:2] * 2.0 * torch.pi
    # A straight edge across the image: the side of it that lies first in a random direction is hidden.
    along = (points[..., 0] * angle.cos() + points[..., 1] * angle.sin()) / points[..., 2].clamp(min=1e-3)
    low = along.masked_fill(~present, torch.inf).amin(dim=1, keepdim=True)
    high = along.masked_fill(~present, -torch.inf).amax(dim=1, keepdim=True)
    fraction = noise[:, 2:3] * config.hide_fraction
    edge = torch.where(noise[:, 3:] < config.hide_probability, low + (high - low) * fraction, -torch.inf)
    return _unless_too_few(present & (along > edge), present, config.min_points)


def disturb_colour(
    rgb: UInt8[Tensor, "b s s 3"], noise: Float[Tensor, "b 5"], config: AugmentConfig
) -> UInt8[Tensor, "b s s 3"]:
    """Return crops with random brightness, contrast and white balance."""
    change = ((noise * 2.0 - 1.0) * config.colour)[:, None, None]
    gain = (1.0 + change[..., :1]) * (1.0 + change[..., 2:] / 2.0)
    contrast = 1.0 + change[..., 1:2]
    values = rgb.float()
    offset = values.mean(dim=(1, 2), keepdim=True) * (1.0 - contrast) * gain
    # Rows of pixels times three channels as one axis, which a processor works through in one go.
    count, side = len(rgb), rgb.shape[1]
    factor, offset = (value.expand(-1, -1, side, -1).reshape(count, 1, side * 3) for value in (contrast * gain, offset))
    changed = torch.addcmul(offset, values.view(count, side, side * 3), factor).clamp_(0.0, 255.0).to(torch.uint8)
    return changed.view(rgb.shape)


def _unless_too_few(fewer: Bool[Tensor, "b p"], before: Bool[Tensor, "b p"], least: int) -> Bool[Tensor, "b p"]:
    enough = fewer.sum(dim=1, keepdim=True) >= least
    return torch.where(enough, fewer, before)
