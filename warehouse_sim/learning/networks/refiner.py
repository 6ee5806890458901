"""The refiner: looks at the cloud in the frame of the current estimate and proposes a small correction."""

from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.learning.networks.points import PointBranch, PointConfig, point_layers


@dataclass(frozen=True)
class RefinerConfig:
    """Sizes of the refiner."""

    local: tuple[int, int] = (64, 128)
    """Channels of the two per-point layers."""
    pooled: tuple[int, int] = (256, 512)
    """Channels of the two layers before pooling."""
    widths: tuple[int, int] = (256, 128)
    """Channels of the hidden layers after pooling."""


class Refiner(nn.Module):
    """Predict the residual pose ``T_estimate_object`` from the cloud in the estimate's frame.

    Args:
        config: Widths.
        colour_channels: Channels of the colour embedding at each point, 0 for none.
        classes: Number of CAD geometries that the network knows.
    """

    def __init__(self, config: RefinerConfig, colour_channels: int, classes: int) -> None:
        super().__init__()
        points = PointConfig(local=config.local, pooled=config.pooled, pooling="average+max")
        self.branch = PointBranch(points, colour_channels)
        self.hidden = point_layers(self.branch.global_channels, *config.widths)
        self.output = nn.Linear(config.widths[-1], 7 * classes)
        # The first correction is none: an untrained refiner leaves the estimate as it is.
        nn.init.zeros_(self.output.weight)
        nn.init.zeros_(self.output.bias)

    def forward(
        self,
        points: Float[Tensor, "b n 3"],
        colour: Float[Tensor, "b n e"] | None,
        class_index: Int[Tensor, " b"],
    ) -> tuple[Float[Tensor, "b 4"], Float[Tensor, "b 3"]]:
        """Return quaternion (wxyz, not normalised) and translation of the correction, in normalised units.

        Args:
            points: Cloud in the frame of the current estimate, normalised.
            colour: Colour embedding gathered at the points.
            class_index: Class of each object.
        """
        _, whole = self.branch(points, colour)
        values = self.output(self.hidden(whole)).float().view(len(points), -1, 7)
        chosen = values[torch.arange(len(points), device=points.device), class_index]
        identity = torch.tensor([1.0, 0.0, 0.0, 0.0], device=points.device)
        return chosen[:, :4] + identity, chosen[:, 4:]
