"""The point branch: shared layers on each point, then a pooled description of the whole object."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor, nn


@dataclass(frozen=True)
class PointConfig:
    """Sizes of the point branch."""

    count: int = 256
    """Points drawn from each object, >= 1."""
    local: tuple[int, int] = (64, 128)
    """Channels of the two per-point layers, on geometry and on colour alike."""
    pooled: tuple[int, int] = (256, 512)
    """Channels of the two layers before pooling."""
    pooling: Literal["average", "average+max"] = "average+max"
    """How points are summed up; the original averages."""


def point_layers(*widths: int) -> nn.Sequential:
    """Return layers shared by all points, each followed by ReLU: (b, n, widths[0]) -> (b, n, widths[-1])."""
    layers: list[nn.Module] = []
    for before, after in pairwise(widths):
        layers += [nn.Linear(before, after), nn.ReLU()]
    return nn.Sequential(*layers)


class PointBranch(nn.Module):
    """Fuse geometry with colour at each point, as PoseNetFeat of DenseFusion does.

    Args:
        config: Widths.
        colour_channels: Channels of the colour embedding at each point, 0 for none.
    """

    def __init__(self, config: PointConfig, colour_channels: int) -> None:
        super().__init__()
        first, second = config.local
        self.geometry_1, self.geometry_2 = point_layers(3, first), point_layers(first, second)
        self.has_colour = colour_channels > 0
        if self.has_colour:
            self.colour_1, self.colour_2 = point_layers(colour_channels, first), point_layers(first, second)
        branches = 2 if self.has_colour else 1
        self.pooled = point_layers(second * branches, *config.pooled)
        self.pooling = config.pooling
        self.local_channels = (first + second) * branches
        self.global_channels = config.pooled[-1] * (2 if config.pooling == "average+max" else 1)

    def forward(
        self, points: Float[Tensor, "b n 3"], colour: Float[Tensor, "b n e"] | None
    ) -> tuple[Float[Tensor, "b n local"], Float[Tensor, "b global"]]:
        """Return the features of each point and those of the whole object.

        Args:
            points: Cloud in normalised units.
            colour: Colour embedding gathered at the points; None without an image branch.
        """
        features_1 = self.geometry_1(points)
        features_2 = self.geometry_2(features_1)
        if self.has_colour:
            colour_1 = self.colour_1(colour)
            features_1 = torch.cat([features_1, colour_1], dim=-1)
            features_2 = torch.cat([features_2, self.colour_2(colour_1)], dim=-1)
        deep = self.pooled(features_2)
        whole = deep.mean(dim=1)
        if self.pooling == "average+max":
            whole = torch.cat([whole, deep.amax(dim=1)], dim=-1)
        return torch.cat([features_1, features_2], dim=-1), whole
