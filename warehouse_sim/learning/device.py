"""Bring samples to the device that computes."""

import torch
from torch import Tensor


def on_device(values: Tensor, device: torch.device) -> Tensor:
    """Return a tensor of the CPU on ``device``; a GPU is not waited for."""
    if device.type != "cuda" or not values.numel():
        return values.to(device)
    # From memory that stays where it is, a GPU copies when its turn comes.
    return values.pin_memory().to(device, non_blocking=True)
