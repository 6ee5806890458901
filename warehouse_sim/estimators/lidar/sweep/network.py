"""The detector's network on range images: range and height above the floor as channels."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from warehouse_sim.estimators.detectors.yolov5.network import (
    STRIDES,
    BoxRun,
    CellNetwork,
    Conv,
    DetectorNetworkConfig,
    Raw,
)
from warehouse_sim.estimators.images.encoding import CANONICAL_FOCAL_PX, CHANNELS, depth_channels
from warehouse_sim.estimators.lidar.sweep.range_image import SweepGrid
from warehouse_sim.estimators.lidar.sweep.settings import RangeImageConfig, SweepDetectorConfig

_FARTHEST = 45.0
"""Range beyond this (canonical m) is this."""
_LOW, _HIGH = 0.4, 3.0
"""Heights (m) at which the two channels of height are 1: of a pallet, and of a rack's levels."""
_BLOCK = 2
"""Pixels along an edge of the blocks that are judged together ..."""
_SPREAD = 8
"""... and channels that features of cells bring to each block."""
DEPTH_CHANNELS = CHANNELS["depth"]
"""The first ones, those that a detector of depth images reads."""


@dataclass(frozen=True, eq=False)
class SweepRaw(Raw):
    """What the heads give."""

    pixels: Float[Tensor, "b h w"]
    """Whether each pixel shows an object of any class: logits."""


class SweepNetwork(CellNetwork):
    """Detects in batches of range images, or sectors of them, and says which pixels show what is detected.

    Args:
        config: Sizes.
        images: Which directions they show.
    """

    def __init__(self, config: DetectorNetworkConfig, images: RangeImageConfig) -> None:
        channels = DEPTH_CHANNELS + 3
        super().__init__(config, channels)
        # Features of the finest map, spread over blocks of pixels, beside the input itself.
        self.spread = nn.Conv2d(self.pyramid.widths[0], _SPREAD * (STRIDES[0] // _BLOCK) ** 2, 1)
        self.pixels = nn.Sequential(
            Conv(_SPREAD + channels * _BLOCK**2, 16, 3), nn.Conv2d(16, _BLOCK**2, 3, padding=1), nn.PixelShuffle(_BLOCK)
        )
        self.images = images
        self._canonical = CANONICAL_FOCAL_PX / SweepGrid(images).rows_per_rad

    def forward(self, rgb: Tensor | None, depth: Float[Tensor, "b p h w"] | None) -> SweepRaw:
        """Return logits at each level, and of each pixel; arguments as ``encode``."""
        assert depth is not None
        with torch.autocast(depth.device.type, enabled=False):
            channels = self.encode(rgb, depth)
        channels = channels.contiguous(memory_format=torch.channels_last)
        maps = self.pyramid(channels)
        spread = functional.pixel_shuffle(functional.silu(self.spread(maps[0])), STRIDES[0] // _BLOCK)
        blocks = functional.pixel_unshuffle(channels, _BLOCK).to(spread.dtype)
        pixels = self.pixels(torch.cat([spread, blocks], dim=1))
        return SweepRaw(self.cells(maps).maps, pixels[:, 0])

    def encode(self, rgb: Tensor | None, depth: Float[Tensor, "b p h w"] | None) -> Float[Tensor, "b c h w"]:
        """Return the channels: those of depth images, height on two scales, whether it is known.

        Args:
            rgb: None; a LiDAR has no colours.
            depth: Planes: range (m, 0 = no reading), height above the floor (m, NaN = unknown); more are not read.
        """
        assert depth is not None
        metres, height = depth[:, 0].float(), depth[:, 1:2].float()
        known = torch.isfinite(height)
        height = torch.where(known, height, 0.0)
        heights = [(height / scale).clamp(-1.0, 2.0) for scale in (_LOW, _HIGH)]
        return torch.cat([depth_channels(metres * self._canonical, _FARTHEST), *heights, known.float()], dim=1)


@dataclass(frozen=True, kw_only=True)
class SweepRun(BoxRun):
    """Everything that defines a trained detector of sweeps but its weights."""

    images: RangeImageConfig
    """Which directions it sees."""
    train: SweepDetectorConfig
    """How it was trained."""
    kind: str = "sweep-detector"

    def make_network(self) -> SweepNetwork:
        """Return the network with fresh weights."""
        return SweepNetwork(self.network, self.images)
