"""Image branches: a colour crop becomes an embedding at each of its pixels."""

from dataclasses import dataclass
from typing import Literal

from torch import nn

from warehouse_sim.learning.networks.psp import PspResNet18
from warehouse_sim.learning.networks.unet import UNet


@dataclass(frozen=True)
class ImageConfig:
    """Kind and sizes of the image branch."""

    kind: Literal["unet", "psp-resnet18"] = "unet"
    """A small U-Net, or ResNet-18 with pyramid pooling as the original."""
    side_px: int = 48
    """Side of the square crop in pixels, a multiple of 8."""
    width: int = 16
    """Channels of the first stage; 64 in the original."""
    channels: int = 3
    """Channels of the image."""
    embedding: int = 32
    """Channels of the embedding at each pixel."""


def build_image_branch(config: ImageConfig) -> nn.Module:
    """Return a module (b, channels, s, s) -> (b, embedding, s, s)."""
    kinds = {"unet": UNet, "psp-resnet18": PspResNet18}
    return kinds[config.kind](config.channels, config.width, config.embedding)
