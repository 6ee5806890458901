"""Order of training samples of several sizes: the images of one step have one canvas, so that they make one batch."""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Int
from torch import Tensor

from warehouse_sim.learning.samples.order import SampleOrder

_CYCLE = 1000
"""Steps over which each group has its fraction."""


class GroupedOrder(SampleOrder):
    """The samples of each step, all of one group; each group has steps in proportion to its samples.

    Args:
        sizes: Number of samples of each group; samples are numbered through.
        batch: Samples a step.
        seed: Decides the order.
    """

    def __init__(self, sizes: Sequence[int], batch: int, seed: int) -> None:
        self._orders = [SampleOrder(size, batch, seed + number) for number, size in enumerate(sizes)]
        self._starts = np.concatenate([[0], np.cumsum(sizes)])
        ends = np.round(_CYCLE * self._starts / self._starts[-1]).astype(int)
        turns = np.repeat(np.arange(len(sizes)), np.diff(ends))
        self._turns = np.random.default_rng([seed, 7]).permutation(turns)

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the samples of one step."""
        cycle, place = divmod(step, _CYCLE)
        group = int(self._turns[place])
        mine = self._turns == group
        turn = cycle * int(mine.sum()) + int(mine[:place].sum())
        return self._orders[group].indices(turn) + int(self._starts[group])

    def group_of(self, index: Int[Tensor, " b"]) -> tuple[int, Int[Tensor, " b"]]:
        """Return the group of a step's samples, and their numbers in it."""
        group = int(np.searchsorted(self._starts, int(index[0]), side="right")) - 1
        return group, index - torch.tensor(int(self._starts[group]))
