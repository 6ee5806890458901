"""Turn clouds so that gravity points along the y axis, as it does for a camera that looks straight ahead."""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

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
