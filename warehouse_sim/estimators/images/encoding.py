"""What a network reads of an image, as channels.

Depth is canonical: metres at which a camera of the focal length ``CANONICAL_FOCAL_PX`` would see the same object as
large. So one network fits cameras of any focal length, and zooming into an image is one division.
"""

import torch
from jaxtyping import Float, UInt8
from torch import Tensor
from torch.nn import functional

from warehouse_sim.estimators.images.settings import Reading, Reads

CANONICAL_FOCAL_PX = 400.0
FARTHEST = 25.0
"""Depth beyond this (canonical m) is this."""
_RELIEFS = ((5, 0.1), (25, 0.5))
"""Windows (px) whose mean depth is taken off, and the largest difference that is encoded (canonical m)."""
CHANNELS: dict[Reading, int] = {"rgb": 3, "depth": 2 + len(_RELIEFS)}


def channel_count(reads: Reads) -> int:
    """Return the number of channels of an input."""
    return sum(CHANNELS[name] for name in reads)


def encode(
    reads: Reads, rgb: UInt8[Tensor, "b h w 3"] | None, depth: Float[Tensor, "b h w"] | None
) -> Float[Tensor, "b c h w"]:
    """Return the channels of an input in the order of ``reads``.

    Args:
        reads: What is read.
        rgb: Colours; needed if they are read.
        depth: Canonical depth (m), 0 = no reading; needed if it is read.
    """
    parts: list[Tensor] = []
    for name in reads:
        given = rgb if name == "rgb" else depth
        assert given is not None, name
        parts.append(given.permute(0, 3, 1, 2).float() / 255.0 if name == "rgb" else depth_channels(given.float()))
    return torch.cat(parts, dim=1)


def depth_channels(depth: Float[Tensor, "b h w"], farthest: float = FARTHEST) -> Float[Tensor, "b c h w"]:
    """Return clipped depth in tens of metres, where there is any, and its relief in windows of several sizes.

    Networks that compute in 16 bits lose centimetres of a depth of metres; a relief of decimetres keeps them.
    """
    depth = depth[:, None].clamp(max=farthest)
    valid = (depth > 0).to(depth.dtype)
    channels = [depth / 10.0, valid]
    for side, most in _RELIEFS:
        mean = _window_mean(depth, side) / _window_mean(valid, side).clamp(min=1e-3)
        channels.append(((depth - mean) * valid / most).clamp(-1.0, 1.0))
    return torch.cat(channels, dim=1)


def _window_mean(values: Float[Tensor, "b 1 h w"], side: int) -> Float[Tensor, "b 1 h w"]:
    """Return means over windows, zeros beyond the border, by running sums: pooling of large windows is slow."""
    half = side // 2
    sums = functional.pad(values, (half + 1, half, half + 1, half)).cumsum(dim=3)
    sums = (sums[..., side:] - sums[..., :-side]).cumsum(dim=2)
    return (sums[..., side:, :] - sums[..., :-side, :]) / side**2
