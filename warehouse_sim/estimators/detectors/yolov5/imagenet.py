"""Features of photographs that stay as they are: EfficientNet-Lite0, as it was trained on ImageNet.

A network that is trained on synthetic images alone learns what only they show. Features of photographs that are not
trained on cannot, and what is built on them finds real objects better (Hinterstoisser et al., "On Pre-Trained Image
Features and Synthetic Images for Deep Learning", ECCV workshops 2018). Layers as in Tan and Le, "EfficientNet", ICML
2019, without squeezing and with ReLU6, as "EfficientNet-Lite" (2020) has them.
"""

from typing import NamedTuple, Self

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

WIDTHS = (40, 112, 320)
"""Of the maps at strides 8, 16 and 32."""


class _Stage(NamedTuple):
    """Blocks of one width; the first one halves the map where ``stride`` is 2."""

    blocks: int
    kernel: int
    stride: int
    expansion: int
    """Factor on the width inside of a block."""
    width: int


_START = 32
_STAGES = (
    _Stage(1, 3, 1, 1, 16),
    _Stage(2, 3, 2, 6, 24),
    _Stage(2, 5, 2, 6, 40),
    _Stage(3, 3, 2, 6, 80),
    _Stage(3, 5, 1, 6, 112),
    _Stage(4, 5, 2, 6, 192),
    _Stage(1, 3, 1, 6, 320),
)
_MIDDLE, _SPREAD = 127.0 / 255.0, 128.0 / 255.0
"""What is taken off colours of 0 to 1, and what they are divided by."""


class _Convolution(nn.Sequential):
    """Convolution without bias and batch normalisation, worked out as one; each channel alone where ``alone``."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int = 1, alone: bool = False) -> None:
        groups = inputs if alone else 1
        convolution = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False)
        super().__init__(convolution, nn.BatchNorm2d(outputs, eps=1e-3))

    def forward(self, x: Float[Tensor, "b i h w"]) -> Tensor:
        """Return features, at half the size where the stride is 2."""
        convolution, normalisation = self
        assert isinstance(convolution, nn.Conv2d)
        assert isinstance(normalisation, nn.BatchNorm2d)
        mean, variance = normalisation.running_mean, normalisation.running_var
        assert mean is not None
        assert variance is not None
        scale = normalisation.weight / torch.sqrt(variance + normalisation.eps)
        weight = convolution.weight * scale[:, None, None, None]
        if convolution.stride[0] == 2:
            # The original pads maps of even size by one less on the left and above: so does a kernel with zeros there.
            weight = functional.pad(weight, (1, 0, 1, 0))
        bias = normalisation.bias - mean * scale
        return functional.conv2d(x, weight, bias, convolution.stride, convolution.padding, 1, convolution.groups)


class _Block(nn.Module):
    """Inverted residual (Sandler et al., "MobileNetV2", CVPR 2018)."""

    def __init__(self, inputs: int, stage: _Stage, stride: int) -> None:
        super().__init__()
        inner = inputs * stage.expansion
        self.expand = _Convolution(inputs, inner, 1) if stage.expansion > 1 else None
        self.within = _Convolution(inner, inner, stage.kernel, stride, alone=True)
        self.project = _Convolution(inner, stage.width, 1)
        self._shortcut = stride == 1 and inputs == stage.width

    def forward(self, x: Float[Tensor, "b i h w"]) -> Tensor:
        """Return features, at half the size where the stride is 2."""
        inner = x if self.expand is None else functional.relu6(self.expand(x), inplace=True)
        result: Tensor = self.project(functional.relu6(self.within(inner), inplace=True))
        return x + result if self._shortcut else result


class ImageNetFeatures(nn.Module):
    """Maps of features of colours of 0 to 1; nothing in it is trained."""

    def __init__(self) -> None:
        super().__init__()
        self.start = _Convolution(3, _START, 3, 2)
        self.stages, width = nn.ModuleList(), _START
        for stage in _STAGES:
            blocks = nn.Sequential()
            for number in range(stage.blocks):
                blocks.append(_Block(width, stage, stage.stride if number == 0 else 1))
                width = stage.width
            self.stages.append(blocks)
        self.requires_grad_(False)
        self.eval()

    def train(self, mode: bool = True) -> Self:
        """Keep the statistics of ImageNet while what is built on them is trained."""
        return super().train(False)

    @torch.no_grad()
    def forward(self, x: Float[Tensor, "b 3 h w"]) -> tuple[Tensor, Tensor, Tensor]:
        """Return maps at strides 8, 16 and 32, ``WIDTHS`` wide; h and w must be multiples of 32."""
        x = functional.relu6(self.start((x - _MIDDLE) / _SPREAD), inplace=True)
        found = []
        for stage in self.stages:
            x = stage(x)
            found.append(x)
        return found[2], found[4], found[6]
