"""A SegNet of small width: an encoder that pools, a decoder that puts values back where the maxima were.

Badrinarayanan et al., "SegNet", TPAMI 2017; the original has five stages of 64 to 512 filters.
"""

from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn import functional

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
        places: list[Tensor] = []
        for stage in self.down:
            x, place = functional.max_pool2d(stage(x), 2, return_indices=True)
            places.append(place)
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
