"""Features of points, and how they are pooled."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.ranges import Range, ranged

_GROUP = 16


def rectified_average_and_max(deep: Float[Tensor, "b n c"]) -> Float[Tensor, "b 2c"]:
    """Return average and maximum over the points of ReLU(``deep``).

    Torch's own gradient of ReLU, mean and max reads and writes all features of all points about eight times, a fifth
    of a training step on a CPU. This one does it once.
    """
    if torch.is_grad_enabled() and deep.requires_grad:
        return _RectifiedAverageMax.apply(deep)
    deep = torch.relu(deep)
    return torch.cat([deep.mean(dim=1), deep.amax(dim=1)], dim=-1)


class _RectifiedAverageMax(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, deep: Tensor) -> Tensor:
        deep = torch.relu(deep)
        highest, row = _max_over_points(deep)
        ctx.save_for_backward(deep, highest, row)
        return torch.cat([deep.sum(dim=1) / deep.shape[1], highest], dim=-1)

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> Tensor:
        deep, highest, row = ctx.saved_tensors
        of_average, of_max = gradients[0].chunk(2, dim=-1)
        fraction = of_average / deep.shape[1]
        # 0 where ReLU cut off: the features themselves, rectified, say where.
        gradient = torch.ops.aten.threshold_backward(fraction[:, None].expand_as(deep), deep, 0)
        objects, channels = _rows_and_columns(row)
        return gradient.index_put_((objects, row, channels), (fraction + of_max) * (highest > 0))


def _max_over_points(deep: Float[Tensor, "b n c"]) -> tuple[Float[Tensor, "b c"], Int[Tensor, "b c"]]:
    """Return the maximum over points, and which point has it.

    Finding the place of a maximum is slow on a CPU. Its value is not, so groups of points are compared first and
    only the best group is searched.
    """
    if deep.shape[1] % _GROUP:
        highest, row = deep.max(dim=1)
        return highest, row
    groups = deep.unflatten(1, (-1, _GROUP))
    group = groups.amax(dim=2).max(dim=1).indices
    objects, channels = _rows_and_columns(group)
    highest, inside = groups.transpose(2, 3)[objects, group, channels].max(dim=-1)
    return highest, group * _GROUP + inside


def _rows_and_columns(like: Int[Tensor, "b c"]) -> tuple[Int[Tensor, "b 1"], Int[Tensor, " c"]]:
    batch, channels = like.shape
    return torch.arange(batch, device=like.device)[:, None], torch.arange(channels, device=like.device)


_LEAST_TRUST = 0.02
"""An object of whose points fewer are trusted on the whole counts as if so many were."""


@dataclass(frozen=True)
@ranged
class PointConfig:
    """Sizes of the point branch."""

    count: Annotated[int, Range(1, 65_536)] = 256
    """Points drawn from each object, 1-65,536."""
    local: Annotated[tuple[int, int], Range(1, 8192)] = (64, 128)
    """Channels of the two per-point layers, on geometry and on the image embedding alike, 1-8,192."""
    pooled: Annotated[tuple[int, int], Range(1, 8192)] = (256, 512)
    """Channels of the two layers before pooling, 1-8,192."""
    pooling: Literal["average", "average+max"] = "average+max"
    """How points are summed up; the original averages."""


def point_layers(*widths: int) -> nn.Sequential:
    """Return layers shared by all points, each followed by ReLU: (b, n, widths[0]) -> (b, n, widths[-1])."""
    layers: list[nn.Module] = []
    for before, after in pairwise(widths):
        layers += [nn.Linear(before, after), nn.ReLU(inplace=True)]
    return nn.Sequential(*layers)


class PointBranch(nn.Module):
    """Fuse geometry with the image embedding at each point, as PoseNetFeat of DenseFusion does.

    Args:
        config: Widths.
        embedding_channels: Channels of the image embedding at each point, 0 for none.
        remarks: What else is known of each point, in channels.
        both_layers: Whether the whole object is described by the features of both layers; else by those of the second.
    """

    def __init__(
        self, config: PointConfig, embedding_channels: int, remarks: int = 0, both_layers: bool = False
    ) -> None:
        super().__init__()
        first, second = config.local
        self.geometry_1, self.geometry_2 = point_layers(3 + remarks, first), point_layers(first, second)
        self.has_image = embedding_channels > 0
        if self.has_image:
            self.image_1, self.image_2 = point_layers(embedding_channels, first), point_layers(first, second)
        branches = 2 if self.has_image else 1
        self.both_layers = both_layers
        self.pooled = point_layers((first + second if both_layers else second) * branches, *config.pooled[:-1])
        self.deepest = nn.Linear(*config.pooled[-2:])
        self.pooling = config.pooling
        self.second_channels = second * branches
        self.local_channels = (first + second) * branches
        self.global_channels = config.pooled[-1] * (2 if config.pooling == "average+max" else 1)

    def forward(
        self, points: Float[Tensor, "b n 3"], embedding: Float[Tensor, "b n e"] | None, wanted: int | None = None
    ) -> tuple[Float[Tensor, "b m local"], Float[Tensor, "b global"]]:
        """Return the features of each point and those of the whole object.

        Args:
            points: Cloud in normalised units.
            embedding: Image embedding at the points; None without an image branch.
            wanted: Only so many points' features are returned, the first; None for all.
        """
        first, second = self.layers(points, embedding)
        return local_features(first, second, wanted), self.pool([*first, *second] if self.both_layers else second)

    def describe(
        self,
        points: Float[Tensor, "b n 3"],
        embedding: Float[Tensor, "b n e"] | None,
        trust: Float[Tensor, "b n"] | None = None,
    ) -> Float[Tensor, "b global"]:
        """Return the features of the whole object only, points weighted by ``trust``."""
        first, second = self.layers(points, embedding)
        return self.pool([*first, *second] if self.both_layers else second, trust)

    def layers(self, points: Tensor, embedding: Tensor | None) -> tuple[list[Tensor], list[Tensor]]:
        """Return the features after the first and the second layers, of geometry and, if there is one, of the image.

        Args:
            points: Cloud in normalised units, with what else is known of each point as further channels.
            embedding: Image embedding at the points; None without an image branch.
        """
        first = [self.geometry_1(points)]
        second = [self.geometry_2(first[0])]
        if self.has_image:
            if embedding is None:
                raise ValueError("this network reads an image, but was given no embedding")
            first.append(self.image_1(embedding))
            second.append(self.image_2(first[1]))
        return first, second

    def pool(self, second: list[Tensor], trust: Float[Tensor, "b n"] | None = None) -> Float[Tensor, "b global"]:
        """Return the features of the whole object from those after the second layers, or after both.

        Args:
            second: Features of each point.
            trust: Weight of each point in the average and the maximum, 0-1; None for 1.
        """
        deep = self.deepest(self.pooled(torch.cat(second, dim=-1) if len(second) > 1 else second[0]))
        if trust is None:
            return self._summed_up(deep)
        # Weights are not negative, so that they may stand before the ReLU.
        whole = self._summed_up(deep * trust[..., None].to(deep.dtype))
        average, rest = whole[:, : deep.shape[-1]], whole[:, deep.shape[-1] :]
        return torch.cat([average / trust.mean(dim=1, keepdim=True).clamp(min=_LEAST_TRUST), rest], dim=-1)

    def _summed_up(self, deep: Tensor) -> Tensor:
        if self.pooling == "average+max":
            return rectified_average_and_max(deep)
        return torch.relu(deep).mean(dim=1)


def local_features(
    first: list[Float[Tensor, "b n c"]], second: list[Float[Tensor, "b n c"]], wanted: int | None
) -> Float[Tensor, "b m local"]:
    """Return the features of the first ``wanted`` points; of all for None."""
    return torch.cat([features[:, :wanted] for features in (*first, *second)], dim=-1)
