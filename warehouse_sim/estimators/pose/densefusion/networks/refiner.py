"""The refiner: looks at the cloud in the frame of the current estimate and proposes a small correction."""

from dataclasses import dataclass
from typing import Annotated

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.estimators.pose.densefusion.networks.heads import PerClassLinear, class_bias
from warehouse_sim.estimators.pose.densefusion.networks.points import PointBranch, PointConfig, point_layers
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class RefinerConfig:
    """Sizes of the refiner."""

    local: Annotated[tuple[int, int], Range(1, 8192)] = (64, 128)
    """Channels of the two per-point layers, 1-8,192."""
    pooled: Annotated[tuple[int, int], Range(1, 8192)] = (256, 512)
    """Channels of the two layers before pooling, 1-8,192."""
    widths: Annotated[tuple[int, int], Range(1, 8192)] = (256, 128)
    """Channels of the hidden layers after pooling, 1-8,192."""
    paper: bool = False
    """As the original: both per-point layers are pooled, 384 channels at full width, by their average alone; hidden
    layers of their own for rotation and translation, which do not know the object's class."""


class _Trunk(nn.Module):
    def __init__(self, channels: int, widths: tuple[int, ...], classes: int) -> None:
        super().__init__()
        self.first = nn.Linear(channels, widths[0])
        self.from_class = class_bias(classes, widths[0]) if classes else None
        self.rest = point_layers(*widths)

    def forward(self, whole: Float[Tensor, "b c"], class_index: Int[Tensor, " b"]) -> Float[Tensor, "b out"]:
        hidden = self.first(whole)
        if self.from_class is not None:
            hidden = hidden + self.from_class(class_index).to(hidden.dtype)
        return self.rest(torch.relu(hidden))


class Refiner(nn.Module):
    """Predict the residual pose ``T_estimate_object`` from the cloud in the estimate's frame.

    Args:
        config: Widths.
        embedding_channels: Channels of the image embedding at each point, 0 for none.
        classes: Number of CAD geometries that the network knows.
    """

    _OUTPUTS = (4, 3)

    def __init__(self, config: RefinerConfig, embedding_channels: int, classes: int) -> None:
        super().__init__()
        points = PointConfig(
            local=config.local, pooled=config.pooled, pooling="average" if config.paper else "average+max"
        )
        self.branch = PointBranch(points, embedding_channels, both_layers=config.paper)
        known = 0 if config.paper else classes
        sizes = self._OUTPUTS if config.paper else (sum(self._OUTPUTS),)
        self.trunks = nn.ModuleList(_Trunk(self.branch.global_channels, config.widths, known) for _ in sizes)
        self.outputs = nn.ModuleList(PerClassLinear(config.widths[-1], size, classes) for size in sizes)
        # The first correction is none: an untrained refiner leaves the estimate as it is.
        for weight in self.outputs.parameters():
            nn.init.zeros_(weight)

    def forward(
        self,
        points: Float[Tensor, "b n 3"],
        embedding: Float[Tensor, "b n e"] | None,
        class_index: Int[Tensor, " b"],
        trust: Float[Tensor, "b n"] | None = None,
    ) -> tuple[Float[Tensor, "b 4"], Float[Tensor, "b 3"]]:
        """Return quaternion (wxyz, not normalised) and translation of the correction, in normalised units.

        Args:
            points: Cloud in the frame of the current estimate, normalised.
            embedding: Image embedding at the points.
            class_index: Class of each object.
            trust: Weight of each point, 0-1; None for 1.
        """
        whole = self.branch.describe(points, embedding, trust)
        parts = [
            output(trunk(whole, class_index)[:, None], class_index)[:, 0]
            for trunk, output in zip(self.trunks, self.outputs, strict=True)
        ]
        quat, shift = torch.cat(parts, dim=-1).split(self._OUTPUTS, dim=-1)
        return quat + torch.tensor([1.0, 0.0, 0.0, 0.0], device=points.device), shift
