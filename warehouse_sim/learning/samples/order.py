"""Endless, reproducible order of training samples, and the seeds of what single steps draw."""

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
