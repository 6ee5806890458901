"""Endless, reproducible order of training samples, of one canvas or several, and the seeds of single steps."""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

_APART, _END = 1_000_003, 2**63


def step_seed(seed: int, number: int, processes: int = 1, rank: int = 0) -> int:
    """Return a seed for one step, or pass, of a run, which torch takes however large that of the run is.

    Args:
        seed: Seed of the run, >= 0.
        number: Which step.
        processes: How many share it.
        rank: Which of them draws.
    """
    return ((seed * _APART + number) * processes + rank) % _END


class SampleOrder:
    """The samples of each step.

    Step k holds the samples k*b to (k+1)*b of one endless row of shuffled passes, so that a resumed run goes on
    where the interrupted one stopped. A pass has as many samples as there are; with weights, a sample occurs in it
    as often as its weight says, rounded up or down at random.

    Args:
        samples: Number of samples.
        batch: Samples a step.
        seed: Decides the order.
        weights: How often each sample is drawn, of mean 1; all once a pass without.
    """

    def __init__(self, samples: int, batch: int, seed: int, weights: Float[Tensor, " k"] | None = None) -> None:
        self._samples, self._batch, self._seed, self._weights = samples, batch, seed, weights
        self._latest = (-1, torch.empty(0, dtype=torch.long))

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the samples of one step."""
        position = torch.arange(step * self._batch, (step + 1) * self._batch)
        passes = position // self._samples
        return torch.cat([
            self._order(int(number))[position[passes == number] % self._samples] for number in passes.unique()
        ])  # fmt: skip

    def _order(self, number: int) -> Int[Tensor, " k"]:
        if self._latest[0] != number:
            self._latest = (number, self._shuffled(number))
        return self._latest[1]

    def _shuffled(self, number: int) -> Int[Tensor, " k"]:
        generator = torch.Generator().manual_seed(step_seed(self._seed, number))
        order = torch.randperm(self._samples, generator=generator)
        if self._weights is None:
            return order
        # Systematic sampling: ticks at equal distances along the weights, laid end to end in random order.
        ends = self._weights[order].double().cumsum(0)
        tick = torch.rand((), generator=generator, dtype=torch.float64)
        ticks = (torch.arange(self._samples) + tick) * (ends[-1] / self._samples)
        chosen = order[torch.searchsorted(ends, ticks).clamp(max=self._samples - 1)]
        return chosen[torch.randperm(self._samples, generator=generator)]


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
