"""What images say at each point of an object, and how what several say is fused by attention over the points."""

from dataclasses import dataclass
from typing import Annotated, Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import adaptive_avg_pool2d, embedding, interpolate, scaled_dot_product_attention

from warehouse_sim.estimators.pose.densefusion.networks.interface import NetworkInput
from warehouse_sim.ranges import Range, ranged


def at_pixels(maps: Float[Tensor, "b h w c"], pixel: Int[Tensor, "b n"]) -> Float[Tensor, "b n c"]:
    """Return the features at row-major indices into each map.

    The maps of the batch are read as one table, whose gradient torch sums row by row.
    """
    batch, height, width, channels = maps.shape
    first = torch.arange(batch, device=maps.device)[:, None] * (height * width)
    return embedding(pixel + first, maps.reshape(-1, channels))


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


@dataclass(frozen=True)
@ranged
class AttentionConfig:
    """Sizes of the fusion of two image branches."""

    embedding: Annotated[int, Range(1, 8192)] = 64
    """Channels E of the tokens and of the result, a multiple of ``heads``, 1-8,192."""
    heads: Annotated[int, Range(1, 128)] = 4
    """Attention heads, 1-128."""

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
        width, self.heads = config.embedding, config.heads
        # Stored weights have a number in their name: there is one set of tokens, of all images.
        self.tokens = nn.ModuleList([nn.Linear(sum(channels), width)])
        self.position = nn.Linear(3, width, bias=False)
        self.norms = nn.ModuleList([nn.LayerNorm(width)])
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
        tokens = self.tokens[0](torch.cat(embeddings, dim=-1)) + self.position(points)
        x = tokens + self._attend(self.norms[0](tokens))
        return x + self.forward_layers(self.forward_norm(x))

    def _attend(self, tokens: Float[Tensor, "b n e"]) -> Float[Tensor, "b n e"]:
        key, value = self.key_value(tokens).chunk(2, dim=-1)
        # (b,n,e) -> (b,heads,n,e/heads)
        parts = [x.unflatten(-1, (self.heads, -1)).transpose(1, 2) for x in (self.query(tokens), key, value)]
        return self.attended(scaled_dot_product_attention(*parts).transpose(1, 2).flatten(2))
