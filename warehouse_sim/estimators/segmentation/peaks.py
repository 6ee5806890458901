"""Read key points off maps of their places."""

from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

_REACH = 3
"""Pixels about the highest one that say where between pixels a point is."""


class Peaks(NamedTuple):
    """Key points of some crops."""

    uv: Float[np.ndarray, "b k 2"]
    """Places (px)."""
    chance: Float[np.ndarray, "b k"]
    """How much of the map lies about the place, 0-1."""


def find_peaks(logits: Float[Tensor, "b k h w"]) -> Peaks:
    """Return the centre of what lies about the highest place of each map."""
    batch, count, height, width = logits.shape
    chance = torch.softmax(logits.flatten(2), dim=2).view(batch, count, height, width).cpu().numpy().astype(float)
    uv, total = np.zeros((batch, count, 2)), np.zeros((batch, count))
    for i in range(batch):
        for k in range(count):
            row, column = divmod(int(chance[i, k].argmax()), width)
            top, left = max(0, row - _REACH), max(0, column - _REACH)
            part = chance[i, k, top : row + _REACH + 1, left : column + _REACH + 1]
            mass = max(float(part.sum()), 1e-12)
            rows, columns = np.indices(part.shape)
            uv[i, k] = left + (columns * part).sum() / mass, top + (rows * part).sum() / mass
            total[i, k] = mass
    return Peaks(uv, np.minimum(total, 1.0))
