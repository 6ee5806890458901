"""The segmenter's network: a small SegNet on crops of boxes; maps of key points and kinds of objects on request."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import torch
from jaxtyping import Float, Int, UInt8
from torch import Tensor, nn
from torch.nn import functional

from warehouse_sim.estimators.images.settings import Reading, Reads
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.ranges import Range, ranged

_FACTORS = (1, 2, 4, 4)
"""Of the width, stage by stage."""


class SegNet(nn.Module):
    """Maps of scores at the size of the input.

    Args:
        channels: Of the input.
        outputs: Number of maps.
        width: Filters of the first stage.
    """

    def __init__(self, channels: int, outputs: int, width: int) -> None:
        super().__init__()
        widths = [width * factor for factor in _FACTORS]
        before = [channels, *widths[:-1]]
        self.down = nn.ModuleList([_stage(a, b) for a, b in zip(before, widths, strict=True)])
        after = [width, *widths[:-1]]
        self.up = nn.ModuleList([_stage(b, a) for a, b in zip(after, widths, strict=True)])
        self.last = nn.Conv2d(width, outputs, 3, padding=1)

    def forward(self, x: Float[Tensor, "b c h w"]) -> Float[Tensor, "b o h w"]:
        """Return scores; h and w must be multiples of 16."""
        return self.decode(*self.encode(x))

    def encode(self, x: Float[Tensor, "b c h w"]) -> tuple[Float[Tensor, "b d hh ww"], list[Tensor]]:
        """Return what the last stage sees, a sixteenth of the size, and where the maxima of each stage were."""
        places: list[Tensor] = []
        for stage in self.down:
            x, place = functional.max_pool2d(stage(x), 2, return_indices=True)
            places.append(place)
        return x, places

    def decode(self, x: Float[Tensor, "b d hh ww"], places: list[Tensor]) -> Float[Tensor, "b o h w"]:
        """Return scores of what ``encode`` returned."""
        for stage, place in zip(reversed(self.up), reversed(places), strict=True):
            x = stage(_unpooled(x, place))
        return self.last(x)


def _unpooled(x: Float[Tensor, "b c h w"], place: Int[Tensor, "b c h w"]) -> Float[Tensor, "b c hh ww"]:
    """Return values at the places where the maxima were, zeros elsewhere."""
    batch, channels, height, width = x.shape
    empty = x.new_zeros((batch, channels, 4 * height * width))
    return empty.scatter(2, place.flatten(2), x.flatten(2)).view(batch, channels, 2 * height, 2 * width)


def _stage(inputs: int, outputs: int) -> nn.Sequential:
    layers = list[nn.Module]()
    for before in (inputs, outputs):
        layers += [nn.Conv2d(before, outputs, 3, padding=1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()]
    return nn.Sequential(*layers)


CHANNELS: dict[Reading, int] = {"rgb": 3, "depth": 4}
_NEAR, _FAR = 0.25, 1.5
"""Depth relative to the object that is encoded finely, and coarsely (m)."""


@dataclass(frozen=True)
@ranged
class SegmenterNetworkConfig:
    """Sizes of a segmenter's network."""

    reads: Reads = ("depth",)
    """Inputs, in the order of their channels."""
    width: Annotated[int, Range(4, 512)] = 16
    """Filters of the first stage, 4-512."""
    keypoints: Annotated[int, Range(0, 1000)] = 0
    """Number of key points, 0-1,000."""
    kinds: tuple[str, ...] = ()
    """Names of the objects that it distinguishes."""


class Said(NamedTuple):
    """What the network says of b boxes, as logits."""

    mask: Float[Tensor, "b h w"]
    places: Float[Tensor, "b p h w"]
    """Of each key point."""
    kinds: Float[Tensor, "b k"]
    """Of each object that it distinguishes, all equally frequent."""


_CELLS_HW, _HIDDEN, _DROPPED = (4, 8), 128, 0.2
"""Of what decides between kinds: cells of the crop, features, and how many of them are dropped in training."""


class SegmenterNetwork(nn.Module):
    """Segments the object in each box.

    Args:
        config: Sizes.
    """

    def __init__(self, config: SegmenterNetworkConfig) -> None:
        super().__init__()
        self.config = config
        channels = sum(CHANNELS[name] for name in config.reads)
        self.segnet = SegNet(channels, 1 + config.keypoints, config.width)
        self.kinds: nn.Module | None = None
        if config.kinds:
            seen = config.width * _FACTORS[-1] * _CELLS_HW[0] * _CELLS_HW[1]
            hidden = nn.Linear(seen, _HIDDEN)
            self.kinds = nn.Sequential(
                nn.Flatten(), nn.Dropout(_DROPPED), hidden, nn.ReLU(), nn.Linear(_HIDDEN, len(config.kinds))
            )

    def forward(
        self,
        rgb: UInt8[Tensor, "b h w 3"] | None,
        depth: Float[Tensor, "b h w"] | None,
        width_rad: Float[Tensor, " b"],
    ) -> Said:
        """Return logits of the mask, of each key point's place, and of kinds.

        Args:
            rgb: Colours, if they are read.
            depth: Metres, 0 = no reading, if it is read.
            width_rad: Width of the crop over the focal length: times the distance, it is metres.
        """
        parts: list[Tensor] = []
        for name in self.config.reads:
            given = rgb if name == "rgb" else depth
            assert given is not None, name
            parts.append(given.permute(0, 3, 1, 2).float() / 255.0 if name == "rgb" else relative(given, width_rad))
        deep, maxima = self.segnet.encode(torch.cat(parts, dim=1))
        maps = self.segnet.decode(deep, maxima)
        kinds = deep.new_zeros((len(deep), 0))
        if self.kinds is not None:
            kinds = self.kinds(functional.adaptive_avg_pool2d(deep, _CELLS_HW))
        return Said(maps[:, 0], maps[:, 1:], kinds)


def relative(depth: Float[Tensor, "b h w"], width_rad: Float[Tensor, " b"]) -> Float[Tensor, "b 4 h w"]:
    """Return depth relative to the median in the middle of the crop, fine and coarse; where there is any; the size.

    The last channel is the logarithm of the crop's width in metres: how large the object would be.
    """
    _, height, width = depth.shape
    middle = depth[:, height // 4 : height - height // 4, width // 5 : width - width // 5].flatten(1)
    valid = middle > 0
    # The median of the valid ones: they come last in order, zeros first.
    ordered = middle.sort(dim=1).values
    count = valid.sum(dim=1)
    place = (middle.shape[1] - count + count // 2).clamp(max=middle.shape[1] - 1)
    distance = ordered.gather(1, place[:, None])[:, 0].clamp(min=0.1)
    offset = (depth - distance[:, None, None]) * (depth > 0)
    size = (width_rad * distance).clamp(0.05, 20.0).log()[:, None, None].expand_as(depth)
    channels = [(offset / _NEAR).clamp(-1, 1), (offset / _FAR).clamp(-1, 1), (depth > 0).to(depth.dtype), size]
    return torch.stack(channels, dim=1)


@dataclass(frozen=True)
class KnownFaces:
    """An object whose key points are known: size and pockets say where they are."""

    obj_id: int
    name: str
    class_name: str
    points: tuple[tuple[float, ...], ...]
    """Of each side with pockets, six points one after the other (m, object frame)."""
    known: tuple[tuple[bool, ...], ...]
    """Which of the six each side has."""


@dataclass(frozen=True, kw_only=True)
class SegmenterRun(RunConfig):
    """Everything that defines a trained segmenter but its weights."""

    objects: tuple[KnownFaces, ...]
    """What was trained on and has pockets."""
    crop: BoxCropConfig
    """How boxes are cut out."""
    network: SegmenterNetworkConfig
    """Sizes of the network."""
    train: SegmenterConfig
    """How it was trained."""
    kind: str = "segmenter"

    def make_network(self) -> SegmenterNetwork:
        """Return the network with fresh weights."""
        return SegmenterNetwork(self.network)
