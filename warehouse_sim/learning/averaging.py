"""Exponential moving average of a network's weights, which is less noisy than the weights of any one step."""

import torch
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel

Tensors = list[Tensor] | tuple[Tensor, ...]


class MovingAverage(AveragedModel):
    """Keep the average of a network's parameters and buffers.

    Args:
        network: Whose weights; the average begins with them.
        decay: Fraction of the average that stays at each step, below 1. The first steps count more, (1 + n) / (10 + n)
            after n steps, so that a short run forgets its random start; 0 makes the average the weights themselves.
    """

    def __init__(self, network: nn.Module, decay: float) -> None:
        super().__init__(network, multi_avg_fn=self._blend, use_buffers=True)
        self._decay, self._fraction = decay, 1.0
        self.update_parameters(network)  # the first update copies

    def follow(self, network: nn.Module, step: int) -> None:
        """Move the average towards the weights after ``step`` steps."""
        self._fraction = 1.0 - min(self._decay, (1.0 + step) / (10.0 + step))
        # What update_parameters does, without its copy of a counter to the GPU, for which it waits at each step.
        pairs = list(zip(_tensors(self.module), _tensors(network), strict=True))
        for kind in {average.dtype for average, _ in pairs}:
            averages, values = zip(*[pair for pair in pairs if pair[0].dtype == kind], strict=True)
            self._blend(averages, values, step)
        self.n_averaged += 1

    @torch.no_grad()
    def _blend(self, averages: Tensors, values: Tensors, _: Tensor | int) -> None:
        """Take over the counters among the buffers, and mix the rest in; tensors of one type at a time."""
        if averages[0].is_floating_point():
            torch._foreach_lerp_(averages, values, self._fraction)
        else:
            torch._foreach_copy_(averages, values)


def _tensors(network: nn.Module) -> list[Tensor]:
    return [tensor.detach() for tensor in (*network.parameters(), *network.buffers())]
