"""ResNet-18 with dilated last stages and a pyramid pooling decoder, DenseFusion's image branch.

Layers after He et al., CVPR 2016, and Zhao et al., "Pyramid Scene Parsing Network", CVPR 2017. With batch
normalisation on request, without the original's unused classifier. The last layer is only computed where points are.
Between pixels a decoder that aligns corners, as the original's, and one that does not disagree by up to half a pixel.
"""

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import adaptive_avg_pool2d, interpolate

from warehouse_sim.estimators.pose.densefusion.networks.pixels import at_pixels


def _conv(before: int, after: int, size: int, stride: int = 1, dilation: int = 1, norm: bool = True) -> nn.Module:
    padding = dilation * (size // 2)
    conv = nn.Conv2d(before, after, size, stride, padding=padding, dilation=dilation, bias=False)
    return nn.Sequential(conv, nn.BatchNorm2d(after)) if norm else _begun(conv)


def _begun(conv: nn.Conv2d) -> nn.Conv2d:
    """Give a convolution He's initial weights, as the original: without normalisation so many layers need them."""
    nn.init.kaiming_normal_(conv.weight, mode="fan_out", nonlinearity="relu")
    return conv


class BasicBlock(nn.Module):
    """Two 3x3 convolutions and a shortcut: (b,i,h,w) -> (b,o,h/stride,w/stride)."""

    def __init__(self, before: int, after: int, stride: int, dilation: int, norm: bool) -> None:
        super().__init__()
        self.main = nn.Sequential(
            _conv(before, after, 3, stride, dilation, norm),
            nn.ReLU(inplace=True),
            _conv(after, after, 3, 1, dilation, norm),
        )
        changed = stride != 1 or before != after
        self.shortcut: nn.Module = nn.Identity()
        if changed:
            shortcut = nn.Conv2d(before, after, 1, stride, bias=False)
            self.shortcut = shortcut if norm else _begun(shortcut)

    def forward(self, x: Float[Tensor, "b i h w"]) -> Float[Tensor, "b o h2 w2"]:
        """Return features after the residual sum."""
        return torch.relu_(self.main(x) + self.shortcut(x))


class PyramidPooling(nn.Module):
    """Concatenate the input with its averages over 1, 2, 3 and 6 bins a side: (b,c,h,w) -> (b,2c,h,w)."""

    _BINS = (1, 2, 3, 6)

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.reduce = nn.ModuleList(nn.Conv2d(channels, channels, 1, bias=False) for _ in self._BINS)
        self.merge = nn.Sequential(nn.Conv2d(channels * (len(self._BINS) + 1), 2 * channels, 1), nn.ReLU())

    def forward(self, x: Float[Tensor, "b c h w"]) -> Float[Tensor, "b c2 h w"]:
        """Return features that know the whole crop."""
        size = x.shape[-2:]
        pooled = [
            interpolate(conv(adaptive_avg_pool2d(x, bins)), size, mode="bilinear", align_corners=False)
            for conv, bins in zip(self.reduce, self._BINS, strict=True)
        ]
        return self.merge(torch.cat([x, *pooled], dim=1))


class Upsample(nn.Module):
    """Double the resolution: (b,i,h,w) -> (b,o,2h,2w)."""

    def __init__(self, before: int, after: int, align_corners: bool = False) -> None:
        super().__init__()
        self.align_corners = align_corners
        self.conv = nn.Sequential(nn.Conv2d(before, after, 3, padding=1), nn.PReLU())

    def forward(self, x: Float[Tensor, "b i h w"]) -> Float[Tensor, "b o h2 w2"]:
        """Return features at twice the resolution."""
        return self.conv(interpolate(x, scale_factor=2.0, mode="bilinear", align_corners=self.align_corners))


class PspResNet18(nn.Module):
    """Embed the pixels of interest of a crop.

    With w = width and side s: stem (b,w,s/2) -> pool (b,w,s/4) -> (b,w,s/4) -> (b,2w,s/8) -> (b,4w,s/8) ->
    (b,8w,s/8) -> pyramid (b,16w,s/8) -> (b,4w,s/4) -> (b,w,s/2) -> (b,w,s) -> at the points (b,n,w) -> (b,n,e).

    Args:
        channels: Channels of the image.
        width: Channels w of the stem, 64 in the original.
        embedding: Channels of the result.
        norm: Whether convolutions of the residual network are followed by batch normalisation; not in the original,
            whose decoder aligns the corners of what it enlarges.
    """

    def __init__(self, channels: int, width: int, embedding: int, norm: bool = True) -> None:
        super().__init__()
        self.stem = nn.Sequential(
            _conv(channels, width, 7, 2, norm=norm), nn.ReLU(inplace=True), nn.MaxPool2d(3, 2, padding=1)
        )
        stages = [(1, 1, 1, 1), (1, 2, 2, 1), (2, 4, 1, 2), (4, 8, 1, 4)]
        # The first block of a dilated stage stays undilated, as in the original.
        blocks = [
            block
            for before, after, stride, dilation in stages
            for block in (
                BasicBlock(before * width, after * width, stride, 1, norm),
                BasicBlock(after * width, after * width, 1, dilation, norm),
            )
        ]
        self.stages = nn.Sequential(*blocks)
        self.pyramid = nn.Sequential(PyramidPooling(8 * width), nn.Dropout2d(0.3))
        self.decoder = nn.Sequential(
            Upsample(16 * width, 4 * width, align_corners=not norm),
            nn.Dropout2d(0.15),
            Upsample(4 * width, width, align_corners=not norm),
            nn.Dropout2d(0.15),
            Upsample(width, width, align_corners=not norm),
        )
        self.out = nn.Linear(width, embedding)

    def forward(self, image: Float[Tensor, "b s s c"], pixel: Int[Tensor, "b n"]) -> Float[Tensor, "b n e"]:
        """Return the embedding at ``pixel``; s must be a multiple of 8."""
        maps = self.decoder(self.pyramid(self.stages(self.stem(image.permute(0, 3, 1, 2)))))
        return self.out(at_pixels(maps.permute(0, 2, 3, 1), pixel))
