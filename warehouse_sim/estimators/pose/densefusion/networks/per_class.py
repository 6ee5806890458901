"""Layers that differ from class to class, at a cost that does not grow with the number of classes."""

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import embedding


class PerClassLinear(nn.Module):
    """A linear layer with weights of its own for each class: each object is multiplied with its class's only.

    Computed in 32 bits, because the result is a pose.

    Args:
        before: Channels of the input.
        after: Channels of the result.
        classes: Number of classes.
    """

    def __init__(self, before: int, after: int, classes: int) -> None:
        super().__init__()
        bound = before**-0.5
        self.weight = nn.Parameter(torch.empty(classes, before, after).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.empty(classes, after).uniform_(-bound, bound))

    def forward(self, x: Float[Tensor, "b n before"], class_index: Int[Tensor, " b"]) -> Float[Tensor, "b n after"]:
        """Return the result of each object's class."""
        with torch.autocast(x.device.type, enabled=False):
            weight = embedding(class_index, self.weight.flatten(1)).unflatten(1, self.weight.shape[1:])
            bias = embedding(class_index, self.bias)
            return torch.baddbmm(bias[:, None], x.float(), weight)


def class_bias(classes: int, width: int) -> nn.Embedding:
    """Return a table of one vector a class, zero at first, to be added to hidden features.

    With it a trunk that all classes share knows which object it looks at, say how long the sides are that it does not
    see; output layers alone, being linear, cannot bring that in. It costs one addition per object and channel.
    """
    table = nn.Embedding(classes, width)
    nn.init.zeros_(table.weight)
    return table
