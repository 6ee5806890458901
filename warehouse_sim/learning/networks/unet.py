"""A small three-level U-Net for crops of about 48 pixels."""

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import interpolate, max_pool2d


def _block(before: int, after: int) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(before, after, 3, padding=1, bias=False), nn.BatchNorm2d(after), nn.ReLU())


class UNet(nn.Module):
    """Embed each pixel with two halvings of resolution and skip connections.

    Args:
        channels: Channels of the image.
        width: Channels w of the first level; the next have 2w and 4w.
        embedding: Channels of the result.
    """

    def __init__(self, channels: int, width: int, embedding: int) -> None:
        super().__init__()
        self.down_1 = _block(channels, width)
        self.down_2 = _block(width, 2 * width)
        self.bottom = nn.Sequential(_block(2 * width, 4 * width), _block(4 * width, 4 * width))
        self.up_2 = _block(6 * width, 2 * width)
        self.up_1 = _block(3 * width, width)
        self.out = nn.Conv2d(width, embedding, 1)

    def forward(self, image: Float[Tensor, "b c s s"]) -> Float[Tensor, "b e s s"]:
        """Return the embedding: (b,w,s,s) -> (b,2w,s/2,s/2) -> (b,4w,s/4,s/4) and back up to (b,e,s,s)."""
        fine = self.down_1(image)
        middle = self.down_2(max_pool2d(fine, 2))
        coarse = self.bottom(max_pool2d(middle, 2))
        middle = self.up_2(torch.cat([middle, interpolate(coarse, scale_factor=2.0)], dim=1))
        fine = self.up_1(torch.cat([fine, interpolate(middle, scale_factor=2.0)], dim=1))
        return self.out(fine)
