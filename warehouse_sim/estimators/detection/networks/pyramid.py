"""Backbone with cross-stage blocks, and the neck that passes features up and down (PAN): three maps of features."""

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from warehouse_sim.estimators.detection.networks.blocks import Conv, CrossStage, PyramidPooling

STRIDES = (8, 16, 32)
"""Pixels of the input to a cell of each map."""


class Pyramid(nn.Module):
    """Backbone and neck.

    Args:
        channels: Of the input.
        width: Factor on the widths 64 to 1,024 of the full network; 0.25 is nano, 0.5 is small.
        depth: Factor on the numbers of bottlenecks 3, 6, 9, 3.
    """

    def __init__(self, channels: int, width: float, depth: float) -> None:
        super().__init__()
        a, b, c, d, e = (_eights(full * width) for full in (64, 128, 256, 512, 1024))
        few, more, most = (max(1, round(count * depth)) for count in (3, 6, 9))
        self.start = nn.Sequential(Conv(channels, a, 6, 2, 2), Conv(a, b, 3, 2), CrossStage(b, b, few))
        self.down_3 = nn.Sequential(Conv(b, c, 3, 2), CrossStage(c, c, more))
        self.down_4 = nn.Sequential(Conv(c, d, 3, 2), CrossStage(d, d, most))
        self.down_5 = nn.Sequential(Conv(d, e, 3, 2), CrossStage(e, e, few), PyramidPooling(e))
        self.narrow_5, self.narrow_4 = Conv(e, d), Conv(d, c)
        self.up_4, self.up_3 = CrossStage(2 * d, d, few, False), CrossStage(2 * c, c, few, False)
        self.again_4, self.again_5 = Conv(c, c, 3, 2), Conv(d, d, 3, 2)
        self.out_4, self.out_5 = CrossStage(2 * c, d, few, False), CrossStage(2 * d, e, few, False)
        self.widths = (c, d, e)
        """Of the three maps."""

    def forward(self, x: Float[Tensor, "b i h w"]) -> tuple[Tensor, Tensor, Tensor]:
        """Return maps of features at each of ``STRIDES``; h and w must be multiples of the last."""
        down_3 = self.down_3(self.start(x))
        down_4 = self.down_4(down_3)
        narrow_5 = self.narrow_5(self.down_5(down_4))
        up_4 = self.narrow_4(self.up_4(torch.cat([_doubled(narrow_5), down_4], dim=1)))
        out_3 = self.up_3(torch.cat([_doubled(up_4), down_3], dim=1))
        out_4 = self.out_4(torch.cat([self.again_4(out_3), up_4], dim=1))
        return out_3, out_4, self.out_5(torch.cat([self.again_5(out_4), narrow_5], dim=1))


def _doubled(x: Float[Tensor, "b c h w"]) -> Tensor:
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")


def _eights(width: float) -> int:
    """Return a width as a multiple of 8, at least 8."""
    return max(8, round(width / 8) * 8)
