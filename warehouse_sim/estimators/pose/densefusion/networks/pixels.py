"""Read feature maps at chosen pixels."""

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import embedding


def at_pixels(maps: Float[Tensor, "b h w c"], pixel: Int[Tensor, "b n"]) -> Float[Tensor, "b n c"]:
    """Return the features at row-major indices into each map.

    The maps of the batch are read as one table, whose gradient torch sums row by row.
    """
    batch, height, width, channels = maps.shape
    first = torch.arange(batch, device=maps.device)[:, None] * (height * width)
    return embedding(pixel + first, maps.reshape(-1, channels))
