"""Building blocks of the YOLOv5 architecture: convolution with SiLU, cross-stage block, fast pyramid pooling."""

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional


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
