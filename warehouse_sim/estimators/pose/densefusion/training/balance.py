"""How often each crop is drawn, so that a class of which there are many does not drown the others."""

from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.settings import Balance


def sampling_weights(
    object_index: Int[Tensor, " k"], classes: Sequence[str], balance: Balance
) -> Float[Tensor, " k"] | None:
    """Return how often each crop is drawn; the mean is 1. None stands for equal weights.

    Args:
        object_index: Object of each crop, 0 to the number of ``classes``.
        classes: Class name of each object.
        balance: What is to be drawn equally often. Within a class, an object is drawn with the square root of its
            number of crops, which lies between equal objects and equal crops.
    """
    if balance == "crops":
        return None
    counts = torch.bincount(object_index, minlength=len(classes)).double()
    fractions = torch.zeros_like(counts)
    for name in set(classes):
        members = torch.tensor([other == name for other in classes])
        if balance == "objects":
            fractions[members] = (counts[members] > 0).double()
        elif counts[members].sum() > 0:
            fractions[members] = counts[members].sqrt() / counts[members].sqrt().sum()
    weights = (fractions / counts.clamp(min=1.0))[object_index]
    return (weights / weights.mean()).float()
