"""Image branches: a crop becomes an embedding at each point's pixel."""

from dataclasses import dataclass
from typing import Annotated, Literal

import torch
from jaxtyping import Float
from torch import Tensor, nn

from warehouse_sim.estimators.pose.densefusion.networks.inputs import NetworkInput
from warehouse_sim.estimators.pose.densefusion.networks.psp import PspResNet18
from warehouse_sim.estimators.pose.densefusion.networks.unet import UNet
from warehouse_sim.ranges import Range, ranged

Reading = Literal["rgb", "depth"]
CHANNELS: dict[Reading, int] = {"rgb": 3, "depth": 2}
"""Channels of each reading; depth comes with a channel that says where it was measured."""

# Mean and standard deviation of ImageNet's colours, made for values of 0 to 1.
_IMAGENET = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


@dataclass(frozen=True)
@ranged
class ImageConfig:
    """Kind and sizes of one image branch."""

    kind: Literal["unet", "psp-resnet18"] = "unet"
    """A small U-Net, or ResNet-18 with pyramid pooling as the original."""
    reads: tuple[Reading, ...] = ("rgb",)
    """What is joined channel-wise at the branch's input: rgb, depth or both."""
    side_px: Annotated[int, Range(8, 181, "px")] = 48
    """Side of the square crop in pixels, a multiple of 8, 8-181."""
    width: Annotated[int, Range(1, 1024)] = 16
    """Channels of the first stage, 1-1,024; 64 in the original."""
    embedding: Annotated[int, Range(1, 8192)] = 32
    """Channels of the embedding at each pixel, 1-8,192."""
    paper: bool = False
    """As the original: ImageNet's statistics on values of 0-255, no batch normalisation, corners aligned, log-softmax
    over channels."""

    def __post_init__(self) -> None:
        if not self.reads or len(set(self.reads)) < len(self.reads):
            raise ValueError(f"an image branch reads rgb, depth or both once, found {self.reads}")
        if self.side_px % 8:
            raise ValueError(f"side_px must be a multiple of 8, found {self.side_px}")


class ImageBranch(nn.Module):
    """Embed the crops of a batch and read the embedding at the points' pixels.

    Args:
        config: Kind and sizes.
    """

    def __init__(self, config: ImageConfig) -> None:
        super().__init__()
        self.config = config
        channels = sum(CHANNELS[reading] for reading in config.reads)
        kinds = {"unet": UNet, "psp-resnet18": PspResNet18}
        extractor = kinds[config.kind](channels, config.width, config.embedding, norm=not config.paper)
        # Convolutions on the CPU are fastest with channels last, which is also how crops are stored.
        self.extractor = extractor.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def forward(self, inputs: NetworkInput) -> Float[Tensor, "b n e"]:
        """Return the embedding at each point."""
        embedding = self.extractor(self.read_inputs(inputs), inputs.pixel)
        return embedding.float().log_softmax(dim=-1) if self.config.paper else embedding

    def read_inputs(self, inputs: NetworkInput) -> Float[Tensor, "b s s c"]:
        """Return the channels of the crops that this branch reads, side by side."""
        images = []
        for reading in self.config.reads:
            image = inputs.rgb if reading == "rgb" else inputs.depth
            if image is None:
                raise ValueError(f"this network reads {reading} crops, the input has none")
            images.append(self._scaled(image) if reading == "rgb" else image.float())
        return images[0] if len(images) == 1 else torch.cat(images, dim=-1)

    def _scaled(self, rgb: Tensor) -> Float[Tensor, "b s s 3"]:
        if not self.config.paper:
            return rgb.float() / 127.5 - 1.0
        mean, deviation = (torch.tensor(values, device=rgb.device) for values in _IMAGENET)
        return (rgb.float() - mean) / deviation
