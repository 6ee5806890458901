"""What the packing tests are run on: every pallet size, and the distances between placed boxes."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack

DECKS = ((1.2, 0.8), (1.2, 1.0), (1.219, 1.016), (0.8, 0.6), (0.6, 0.8), (1.0, 1.2))
"""Edges of the pallets' tops along x and y (m)."""


def least_distance(boxes: Sequence[OrientedBox]) -> float:
    """Return the smallest distance (m) between any two boxes by their separating axes, negative when two overlap."""
    stack = BoxStack.of(boxes)
    pairs = stack.pairs(stack, 0.01)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    return float(stack.separation(stack, pairs).distance.min(initial=0.01))


def reach(boxes: Sequence[OrientedBox]) -> Float[np.ndarray, " 2"]:
    """Return how far from the middle the boxes reach along x and y (m)."""
    return np.abs(np.concatenate([box.corners() for box in boxes])[:, :2]).max(axis=0)
