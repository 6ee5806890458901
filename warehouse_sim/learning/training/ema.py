"""Exponential moving average of a network's weights, which is less noisy than the weights of any one step."""

from typing import Any

import lightning
import torch
from torch import Tensor, nn


class MovingAverage(lightning.Callback):
    """Keep the average of a network's parameters and buffers, and validate with it.

    Lightning's own callback copies the whole training module, and with it the crops that it draws from.

    Args:
        network: Whose weights.
        decay: Share of the average that stays at each step, below 1. The first steps count more, (1 + n) / (10 + n)
            after n steps, so that a short run forgets its random start; 0 makes the average the weights themselves.
    """

    def __init__(self, network: nn.Module, decay: float) -> None:
        self._network, self._decay, self._steps = network, decay, 0
        self._average: dict[str, Tensor] = {}

    def on_fit_start(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Begin with the weights as they are, or bring an earlier session's average to their device."""
        for name, value in self._network.state_dict().items():
            kept = self._average.get(name)
            self._average[name] = value.detach().clone() if kept is None else kept.to(value.device)

    @torch.no_grad()
    def on_train_batch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, *_: object) -> None:
        """Move the average towards the weights after each step."""
        if trainer.global_step <= self._steps:
            return
        self._steps = trainer.global_step
        share = 1.0 - min(self._decay, (1.0 + self._steps) / (10.0 + self._steps))
        averages, values = [], []
        for name, value in self._network.state_dict().items():
            if value.is_floating_point():
                averages.append(self._average[name])
                values.append(value)
            else:
                self._average[name].copy_(value)
        torch._foreach_lerp_(averages, values, share)

    def on_validation_start(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Give the network its average."""
        self._swap()

    def on_validation_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Give the network its weights back."""
        self._swap()

    def apply(self) -> None:
        """Leave the network with its average for good."""
        self._network.load_state_dict(self._average)

    def state_dict(self) -> dict[str, Any]:
        """Return what a later session must know."""
        return {"steps": self._steps, "average": self._average}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Go on from an earlier session."""
        self._steps, self._average = state_dict["steps"], dict(state_dict["average"])

    @torch.no_grad()
    def _swap(self) -> None:
        for name, value in self._network.state_dict().items():
            held = value.clone()
            value.copy_(self._average[name])
            self._average[name].copy_(held)
