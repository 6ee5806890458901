"""Begin a training with the weights of another run."""

import hashlib
from pathlib import Path

import torch
from torch import nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.run_folder import WEIGHTS, StartingWeights, read_weights
from warehouse_sim.resources import model_dir


def start_from(init: str | Path, network: nn.Module) -> StartingWeights:
    """Copy all weights of a run that the network has, too, in the same shape, and return what they were.

    Args:
        init: Bundled name or run folder.
        network: What begins; weights for other classes or inputs stay fresh.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
        TrainingError: The run has no weights, or none that fit.
    """
    folder = model_dir(init)
    given, own = read_weights(folder), network.state_dict()
    fitting = {name: value for name, value in given.items() if name in own and own[name].shape == value.shape}
    if len(fitting) < len(own) / 2:
        raise TrainingError(f"{folder / WEIGHTS} fits {len(fitting)} of {len(own)} arrays of the network; begin afresh")
    with torch.no_grad():
        network.load_state_dict(own | fitting)
    return StartingWeights(str(init), hashlib.sha256((folder / WEIGHTS).read_bytes()).hexdigest())
