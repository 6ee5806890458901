"""The detector's network: a backbone and a pyramid of YOLOv5's blocks, and a head at each level."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import torch
from jaxtyping import Float, UInt8
from torch import Tensor, nn
from torch.nn import functional

from warehouse_sim.estimators.detectors.settings import Backbone, BoxTrainingConfig, DetectorConfig, DetectorSize
from warehouse_sim.estimators.detectors.yolov5 import imagenet
from warehouse_sim.estimators.images.encoding import channel_count, encode
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.ranges import Range, ranged

WIDTHS: dict[DetectorSize, float] = {"pico": 0.125, "nano": 0.25, "small": 0.5}
DEPTH = 0.33
"""Of all three sizes."""


class Conv(nn.Sequential):
    """Convolution without bias, batch normalisation and SiLU."""

    def __init__(self, inputs: int, outputs: int, kernel: int = 1, stride: int = 1, padding: int | None = None) -> None:
        super().__init__(
            nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2 if padding is None else padding, bias=False),
            nn.BatchNorm2d(outputs, eps=1e-3, momentum=0.03),
            nn.SiLU(),
        )


class Bottleneck(nn.Module):
    """Two convolutions, 1x1 and 3x3, beside a shortcut if there is one."""

    def __init__(self, width: int, shortcut: bool) -> None:
        super().__init__()
        self.inner = nn.Sequential(Conv(width, width), Conv(width, width, 3))
        self.shortcut = shortcut

    def forward(self, x: Float[Tensor, "b c h w"]) -> Float[Tensor, "b c h w"]:
        """Return features of the same shape."""
        return x + self.inner(x) if self.shortcut else self.inner(x)


class CrossStage(nn.Module):
    """C3: half of the width passes bottlenecks, half passes by (Wang et al., "CSPNet", CVPRW 2020)."""

    def __init__(self, inputs: int, outputs: int, count: int, shortcut: bool = True) -> None:
        super().__init__()
        half = outputs // 2
        self.through = nn.Sequential(Conv(inputs, half), *(Bottleneck(half, shortcut) for _ in range(count)))
        self.past, self.join = Conv(inputs, half), Conv(2 * half, outputs)

    def forward(self, x: Float[Tensor, "b i h w"]) -> Float[Tensor, "b o h w"]:
        """Return features of the same size."""
        return self.join(torch.cat([self.through(x), self.past(x)], dim=1))


class PyramidPooling(nn.Module):
    """SPPF: three 5x5 maxima, one after the other, see windows of 5, 9 and 13 px."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.enter, self.leave = Conv(width, width // 2), Conv(2 * width, width)

    def forward(self, x: Float[Tensor, "b c h w"]) -> Float[Tensor, "b c h w"]:
        """Return features of the same shape."""
        seen = [self.enter(x)]
        for _ in range(3):
            seen.append(functional.max_pool2d(seen[-1], 5, 1, 2))
        return self.leave(torch.cat(seen, dim=1))


FEATURES = "pyramid.features."
"""How the names of weights begin that are not trained."""
STRIDES = (8, 16, 32)
"""Pixels of the input to a cell of each map."""


class Pyramid(nn.Module):
    """Backbone and neck.

    Args:
        channels: Of the input.
        width: Factor on the widths 64 to 1,024 of the full network; 0.25 is nano, 0.5 is small.
        depth: Factor on the numbers of bottlenecks 3, 6, 9, 3.
        backbone: What sees the input; that of ImageNet sees colours alone.
    """

    def __init__(self, channels: int, width: float, depth: float, backbone: Backbone = "csp") -> None:
        super().__init__()
        # Multiples of 8.
        a, b, c, d, e = (max(8, round(full * width / 8) * 8) for full in (64, 128, 256, 512, 1024))
        few, more, most = (max(1, round(count * depth)) for count in (3, 6, 9))
        self.features = imagenet.ImageNetFeatures() if backbone == "efficientnet_lite0" else None
        if self.features is None:
            self.start = nn.Sequential(Conv(channels, a, 6, 2, 2), Conv(a, b, 3, 2), CrossStage(b, b, few))
            self.down_3 = nn.Sequential(Conv(b, c, 3, 2), CrossStage(c, c, more))
            self.down_4 = nn.Sequential(Conv(c, d, 3, 2), CrossStage(d, d, most))
            self.down_5 = nn.Sequential(Conv(d, e, 3, 2), CrossStage(e, e, few), PyramidPooling(e))
        else:
            fine, middle, coarse = imagenet.WIDTHS
            self.down_3, self.down_4 = Conv(fine, c), Conv(middle, d)
            self.down_5 = nn.Sequential(Conv(coarse, e), PyramidPooling(e))
        self.narrow_5, self.narrow_4 = Conv(e, d), Conv(d, c)
        self.up_4, self.up_3 = CrossStage(2 * d, d, few, False), CrossStage(2 * c, c, few, False)
        self.again_4, self.again_5 = Conv(c, c, 3, 2), Conv(d, d, 3, 2)
        self.out_4, self.out_5 = CrossStage(2 * c, d, few, False), CrossStage(2 * d, e, few, False)
        self.widths = (c, d, e)
        """Of the three maps."""

    def forward(self, x: Float[Tensor, "b i h w"]) -> tuple[Tensor, Tensor, Tensor]:
        """Return maps of features at each of ``STRIDES``; h and w must be multiples of the last."""
        if self.features is None:
            down_3 = self.down_3(self.start(x))
            down_4 = self.down_4(down_3)
            down_5 = self.down_5(down_4)
        else:
            stages = zip((self.down_3, self.down_4, self.down_5), self.features(x), strict=True)
            down_3, down_4, down_5 = (stage(seen) for stage, seen in stages)
        narrow_5 = self.narrow_5(down_5)
        up_4 = self.narrow_4(self.up_4(torch.cat([_doubled(narrow_5), down_4], dim=1)))
        out_3 = self.up_3(torch.cat([_doubled(up_4), down_3], dim=1))
        out_4 = self.out_4(torch.cat([self.again_4(out_3), up_4], dim=1))
        return out_3, out_4, self.out_5(torch.cat([self.again_5(out_4), narrow_5], dim=1))


def _doubled(x: Float[Tensor, "b c h w"]) -> Tensor:
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")


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
    backbone: Backbone = "csp"
    """What sees the input."""

    def __post_init__(self) -> None:
        if not self.anchors or len(self.anchors) % len(STRIDES):
            raise ValueError(f"anchors must be a multiple of {len(STRIDES)} pairs, found {len(self.anchors)}")


@dataclass(frozen=True, eq=False)
class Raw:
    """What the heads give, level after level; a anchors a level."""

    maps: tuple[Float[Tensor, "b a h w o"], ...]
    """Box (4), objectness (1), classes: logits."""


class CellNetwork(nn.Module, ABC):
    """Detects in batches of arrays of one size, whatever their channels are.

    Args:
        config: Sizes.
        channels: Of the encoded input.
    """

    anchors: Float[Tensor, "l a 2"]

    def __init__(self, config: DetectorNetworkConfig, channels: int) -> None:
        super().__init__()
        self.config = config
        self.pyramid = Pyramid(channels, config.width, config.depth, config.backbone)
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


@dataclass(frozen=True, kw_only=True)
class BoxRun(RunConfig):
    """Everything that defines a trained network that gives boxes but its weights."""

    classes: tuple[str, ...]
    """The classes that it distinguishes, in the order of the network's classes."""
    images: Any
    """What it reads."""
    network: DetectorNetworkConfig
    """Sizes of the network."""
    train: BoxTrainingConfig
    """How it was trained."""

    @abstractmethod
    def make_network(self) -> CellNetwork:
        """Return the network with fresh weights."""


@dataclass(frozen=True, kw_only=True)
class DetectorRun(BoxRun):
    """What defines a detector of images."""

    images: ImageConfig
    """What it reads."""
    train: DetectorConfig
    """How it was trained."""
    kind: str = "detector"

    def make_network(self) -> DetectorNetwork:
        """Return the network with fresh weights."""
        return DetectorNetwork(self.network, self.images)
