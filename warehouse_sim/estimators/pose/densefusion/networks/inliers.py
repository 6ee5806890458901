"""Which points are the object's: a logit a point, from the point itself and from the others."""

from dataclasses import dataclass
from typing import Annotated

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.estimators.pose.densefusion.networks.heads import SplitTrunk
from warehouse_sim.estimators.pose.densefusion.networks.points import point_layers
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class InlierConfig:
    """Sizes of the head that tells the object's points from others."""

    summary: Annotated[int, Range(1, 8192)] = 64
    """Channels of what is summed up over the points, 1-8,192."""
    widths: Annotated[tuple[int, ...], Range(1, 8192)] = (64, 32)
    """Channels of the hidden layers, 1-8,192."""


class InlierHead(nn.Module):
    """Say of each point whether it is the object's, before the points are summed up to an object.

    The points in the mask and those around it are summed up apart: what all points of a mask have in common, and what
    is around it, is what a point is compared with.

    Args:
        config: Sizes.
        channels: Channels of the points' features.
        classes: Number of CAD geometries that the network knows.
    """

    def __init__(self, config: InlierConfig, channels: int, classes: int) -> None:
        super().__init__()
        self.summary = point_layers(channels, config.summary)
        self.trunk = SplitTrunk(channels, 3 * config.summary, config.widths, classes)
        self.output = nn.Linear(config.widths[-1], 1)

    def forward(
        self, features: Float[Tensor, "b n c"], inside: Float[Tensor, "b n"], class_index: Int[Tensor, " b"]
    ) -> Float[Tensor, "b n"]:
        """Return the trust in each point before the sigmoid.

        Args:
            features: Of each point.
            inside: 1 where the mask holds the point, else 0.
            class_index: Class of each object.
        """
        deep = self.summary(features)
        within = inside[..., None].to(deep.dtype)
        held, rest = deep * within, deep * (1.0 - within)
        fraction = within.mean(dim=1)
        # A small number keeps the average defined where the mask holds all points, or none.
        whole = [held.mean(dim=1) / (fraction + 1e-3), held.amax(dim=1), rest.mean(dim=1) / (1.0 - fraction + 1e-3)]
        hidden = self.trunk(features, torch.cat(whole, dim=-1), class_index)
        return self.output(hidden)[..., 0].float()
