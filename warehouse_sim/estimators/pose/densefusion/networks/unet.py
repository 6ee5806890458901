"""A small U-Net for crops of about 48 pixels, made for training on few CPU cores.

Most of a U-Net's cost is in its finest levels. Here the finest convolution works on cells of 2x2 pixels, skips are
added rather than concatenated, and the last layer is only computed where points are.
"""

from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import interpolate

from warehouse_sim.estimators.pose.densefusion.networks.pixels import at_pixels


def _block(before: int, after: int, stride: int = 1, norm: bool = True) -> nn.Sequential:
    conv = nn.Conv2d(before, after, 3, stride, padding=1, bias=not norm)
    layers = [conv, nn.BatchNorm2d(after)] if norm else [conv]
    return nn.Sequential(*layers, nn.ReLU(inplace=True))


class UNet(nn.Module):
    """Embed the pixels of interest, with two halvings of resolution below the cells.

    Args:
        channels: Channels of the image.
        width: Channels w of the finest level; the next have 2w and 4w.
        embedding: Channels of the result.
        norm: Whether convolutions are followed by batch normalisation.
    """

    def __init__(self, channels: int, width: int, embedding: int, norm: bool = True) -> None:
        super().__init__()
        self.cells = _block(4 * channels, width, norm=norm)
        self.down_2 = _block(width, 2 * width, stride=2, norm=norm)
        self.down_3 = _block(2 * width, 4 * width, stride=2, norm=norm)
        self.bottom = _block(4 * width, 4 * width, norm=norm)
        self.narrow_2 = nn.Conv2d(4 * width, 2 * width, 1)
        self.up_2 = _block(2 * width, 2 * width, norm=norm)
        self.narrow_1 = nn.Conv2d(2 * width, width, 1)
        self.up_1 = _block(width, width, norm=norm)
        self.from_cell = nn.Linear(width, embedding)
        self.from_pixel = nn.Linear(channels, embedding, bias=False)

    def forward(self, image: Float[Tensor, "b s s c"], pixel: Int[Tensor, "b n"]) -> Float[Tensor, "b n e"]:
        """Return the embedding at ``pixel``: (b,w,s/2,s/2) -> (b,2w,s/4,s/4) -> (b,4w,s/8,s/8) and back up."""
        batch, side, _, channels = image.shape
        half = side // 2
        cells = image.view(batch, half, 2, half, 2, channels).transpose(2, 3).reshape(batch, half, half, 4 * channels)
        fine = self.cells(cells.permute(0, 3, 1, 2))
        middle = self.down_2(fine)
        coarse = self.bottom(self.down_3(middle))
        middle = self.up_2(middle + interpolate(self.narrow_2(coarse), scale_factor=2.0))
        fine = self.up_1(fine + interpolate(self.narrow_1(middle), scale_factor=2.0))
        row, column = pixel // side, pixel % side
        cell = (row // 2) * half + column // 2
        at_cell = self.from_cell(at_pixels(fine.permute(0, 2, 3, 1), cell))
        return at_cell + self.from_pixel(at_pixels(image, pixel))
