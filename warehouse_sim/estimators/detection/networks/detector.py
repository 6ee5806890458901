"""The detector's network: encoded input, pyramid, and at each cell three anchors with box, objectness, classes."""

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import torch
from jaxtyping import Float, UInt8
from torch import Tensor, nn

from warehouse_sim.estimators.detection.networks.boxes import BoxNetwork
from warehouse_sim.estimators.detection.networks.pyramid import STRIDES, Pyramid
from warehouse_sim.estimators.images.encoding import channel_count, encode
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.ranges import Range, ranged

Anchors = Annotated[tuple[tuple[float, float], ...], Range(0.1, 100_000, "px")]
ANCHORS: Anchors = (
    *((10, 13), (16, 30), (33, 23)),
    *((30, 61), (62, 45), (59, 119)),
    *((116, 90), (156, 198), (373, 326)),
)
"""Those of the original, made for COCO at 640 px; training finds those of its own boxes."""


@dataclass(frozen=True)
@ranged
class DetectorNetworkConfig:
    """Sizes of a detector's network."""

    width: Annotated[float, Range(0.01, 10)] = 0.25
    """Factor on the full widths, 0.01-10."""
    depth: Annotated[float, Range(0.01, 10)] = 0.33
    """Factor on the full numbers of bottlenecks, 0.01-10."""
    classes: Annotated[int, Range(1, 10_000)] = 1
    """Number of classes, 1-10,000."""
    anchors: Anchors = ANCHORS
    """Width and height (px of the canvas) of the anchors, as many for each level, those of the finest level first."""

    def __post_init__(self) -> None:
        if not self.anchors or len(self.anchors) % len(STRIDES):
            raise ValueError(f"anchors must be a multiple of {len(STRIDES)} pairs, found {len(self.anchors)}")


@dataclass(frozen=True, eq=False)
class Raw:
    """What the heads give, level after level; a anchors a level."""

    maps: tuple[Float[Tensor, "b a h w o"], ...]
    """Box (4), objectness (1), classes: logits."""


class CellNetwork(BoxNetwork):
    """Detects in batches of arrays of one size, whatever their channels are.

    Args:
        config: Sizes.
        channels: Of the encoded input.
    """

    anchors: Float[Tensor, "l a 2"]

    def __init__(self, config: DetectorNetworkConfig, channels: int) -> None:
        super().__init__(config.classes)
        self.config = config
        self.pyramid = Pyramid(channels, config.width, config.depth)
        anchors = torch.tensor(config.anchors, dtype=torch.float32).reshape(len(STRIDES), -1, 2)
        self.register_buffer("anchors", anchors, persistent=False)
        outputs = anchors.shape[1] * (5 + config.classes)
        self.heads = nn.ModuleList([nn.Conv2d(width, outputs, 1) for width in self.pyramid.widths])
        self._start_rare()

    @abstractmethod
    def encode(self, rgb: Tensor | None, depth: Tensor | None) -> Float[Tensor, "b c h w"]:
        """Return the channels of an input."""

    def forward(self, rgb: Tensor | None, depth: Tensor | None) -> Raw:
        """Return logits at each level.

        Args:
            rgb: Colours, if they are read.
            depth: Canonical depth (m), if it is read.
        """
        with torch.autocast((depth if rgb is None else rgb).device.type, enabled=False):  # type: ignore[union-attr]
            channels = self.encode(rgb, depth)
        channels = channels.contiguous(memory_format=torch.channels_last)
        return self.cells(self.pyramid(channels))

    def cells(self, maps: Sequence[Float[Tensor, "b c h w"]]) -> Raw:
        """Return logits of the pyramid's maps of features."""
        return Raw(tuple(self._split(head(x)) for head, x in zip(self.heads, maps, strict=True)))

    def decode(self, raw: Raw) -> tuple[Float[Tensor, "b n 4"], Float[Tensor, "b n k"]]:
        """Return boxes (edges on the canvas, px) and the score of each class, of all cells and anchors."""
        boxes: list[Tensor] = []
        scores: list[Tensor] = []
        for level, found in enumerate(raw.maps):
            xy, wh = self.place(found[..., :4].float(), level)
            chance = torch.sigmoid(found[..., 4:].float())
            boxes.append(torch.cat([xy - wh / 2, xy + wh / 2], dim=-1).flatten(1, 3))
            # Of one class, objectness says it all, and the class was not trained.
            scores.append((chance[..., :1] * (chance[..., 1:] if self.config.classes > 1 else 1.0)).flatten(1, 3))
        return torch.cat(boxes, dim=1), torch.cat(scores, dim=1)

    def place(self, logits: Float[Tensor, "b a h w 4"], level: int) -> tuple[Tensor, Tensor]:
        """Return centre and size (px of the canvas) of the boxes of a level."""
        stride, (height, width) = STRIDES[level], logits.shape[2:4]
        rows, columns = torch.meshgrid(
            torch.arange(height, device=logits.device), torch.arange(width, device=logits.device), indexing="ij"
        )
        cell = torch.stack([columns, rows], dim=-1).to(logits.dtype)
        fraction = torch.sigmoid(logits)
        centre = (2.0 * fraction[..., :2] - 0.5 + cell) * stride
        return centre, (2.0 * fraction[..., 2:]) ** 2 * self.anchors[level][None, :, None, None]

    def _split(self, x: Float[Tensor, "b c h w"]) -> Float[Tensor, "b a h w o"]:
        batch, _, height, width = x.shape
        return x.view(batch, self.anchors.shape[1], -1, height, width).permute(0, 1, 3, 4, 2)

    def _start_rare(self) -> None:
        """Begin with the odds of an image of eight objects, so that empty cells have little to unlearn."""
        for head, stride in zip(self.heads, STRIDES, strict=True):
            assert isinstance(head, nn.Conv2d)
            assert head.bias is not None
            bias = head.bias.data.view(self.anchors.shape[1], -1)
            bias[:, 4] += math.log(8 / (640 / stride) ** 2)
            bias[:, 5:] += math.log(0.6 / (self.config.classes - 0.99999)) if self.config.classes > 1 else 3.0


class DetectorNetwork(CellNetwork):
    """Detects in batches of images of one size.

    Args:
        config: Sizes.
        images: What is read.
    """

    def __init__(self, config: DetectorNetworkConfig, images: ImageConfig) -> None:
        super().__init__(config, channel_count(images.reads))
        self.images = images

    def encode(
        self, rgb: UInt8[Tensor, "b h w 3"] | None, depth: Float[Tensor, "b h w"] | None
    ) -> Float[Tensor, "b c h w"]:
        """Return the channels of colours and canonical depths, as far as they are read."""
        return encode(self.images.reads, rgb, depth)
