"""Fuse what several images say about each point by attention over the points of an object."""

from dataclasses import dataclass
from typing import Annotated, Literal

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import scaled_dot_product_attention

from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class AttentionConfig:
    """Sizes of the fusion of two image branches."""

    embedding: Annotated[int, Range(1, 8192)] = 64
    """Channels E of the tokens and of the result, a multiple of ``heads``, 1-8,192."""
    heads: Annotated[int, Range(1, 128)] = 4
    """Attention heads, 1-128."""
    kind: Literal["self", "cross"] = "self"
    """self: tokens of all images at once. cross: the first image asks, the second answers."""

    def __post_init__(self) -> None:
        if self.embedding % self.heads:
            raise ValueError(f"the embedding ({self.embedding}) must be a multiple of heads ({self.heads})")


class AttentionFusion(nn.Module):
    """One pre-norm transformer layer over the points: (b,n,e1) and (b,n,e2) -> (b,n,E).

    Token = linear map of the embeddings + linear map of the point's position. Points, not pixels, attend to each
    other, so the cost is N^2 E. Vaswani et al., "Attention is all you need", NeurIPS 2017; pre-norm after Xiong et
    al., ICML 2020.

    Args:
        config: Sizes.
        channels: Channels of each image's embedding.
    """

    def __init__(self, config: AttentionConfig, channels: tuple[int, ...]) -> None:
        super().__init__()
        width, self.heads, self.kind = config.embedding, config.heads, config.kind
        if config.kind == "cross" and len(channels) != 2:
            raise ValueError(f"cross-attention joins two images, found {len(channels)}")
        # One set of tokens of all images, or one set of each.
        sizes = channels if config.kind == "cross" else (sum(channels),)
        self.tokens = nn.ModuleList(nn.Linear(size, width) for size in sizes)
        self.position = nn.Linear(3, width, bias=False)
        self.norms = nn.ModuleList(nn.LayerNorm(width) for _ in sizes)
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(width, 2 * width)
        self.attended = nn.Linear(width, width)
        self.forward_norm = nn.LayerNorm(width)
        self.forward_layers = nn.Sequential(
            nn.Linear(width, 2 * width), nn.ReLU(inplace=True), nn.Linear(2 * width, width)
        )

    def forward(
        self, embeddings: list[Float[Tensor, "b n e"]], points: Float[Tensor, "b n 3"]
    ) -> Float[Tensor, "b n out"]:
        """Return one embedding a point.

        Args:
            embeddings: Of each image, at the points.
            points: Cloud in normalised units.
        """
        sets = embeddings if self.kind == "cross" else [torch.cat(embeddings, dim=-1)]
        where = self.position(points)
        tokens = [layer(values) + where for layer, values in zip(self.tokens, sets, strict=True)]
        normed = [norm(values) for norm, values in zip(self.norms, tokens, strict=True)]
        x = tokens[0] + self._attend(normed[0], normed[-1])
        return x + self.forward_layers(self.forward_norm(x))

    def _attend(self, asking: Float[Tensor, "b n e"], answering: Float[Tensor, "b n e"]) -> Float[Tensor, "b n e"]:
        key, value = self.key_value(answering).chunk(2, dim=-1)
        # (b,n,e) -> (b,heads,n,e/heads)
        parts = [x.unflatten(-1, (self.heads, -1)).transpose(1, 2) for x in (self.query(asking), key, value)]
        return self.attended(scaled_dot_product_attention(*parts).transpose(1, 2).flatten(2))
