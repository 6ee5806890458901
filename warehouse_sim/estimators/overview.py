"""What there is to choose from: each estimator's inputs and size, and how well its bundled weights do."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import torch

from warehouse_sim.learning.methods import ESTIMATORS
from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.settings import Size
from warehouse_sim.resources import model_dir, model_names
from warehouse_sim.yaml_file import read_yaml

CARD, RESULT = "card.yaml", "result.json"


@dataclass(frozen=True)
class Overview:
    """One estimator in a few words."""

    name: str
    inputs: str
    """What it reads of an observation."""
    parameters: dict[str, int]
    """Number of weights by size, for one object."""
    bundled: str
    """Score and speed of the bundled weights; empty when there are none."""


def overview(name: str) -> Overview:
    """Return what is known of a registered estimator.

    Raises:
        UnknownNameError: No such estimator.
    """
    method = ESTIMATORS.get(name)
    bundled = describe_model(model_dir(name)) if name in model_names() else ""
    return Overview(name, method.inputs, {size: parameters(name, size) for size in get_args(Size)}, bundled)


def parameters(name: str, size: Size, classes: int = 1) -> int:
    """Return the number of weights of an estimator's network."""
    # On this device tensors have shapes and no memory.
    with torch.device("meta"):
        network = DenseFusion(ESTIMATORS.get(name).network(size), classes)
    return sum(parameter.numel() for parameter in network.parameters())


def describe_model(folder: Path) -> str:
    """Return score and speed of a bundled model: what its card says, else what its training saw on val.

    ``card.yaml`` may hold ``score`` and ``speed``, each one short text.
    """
    if (folder / CARD).is_file():
        card = read_yaml(folder / CARD)
        return "; ".join(str(card[key]) for key in ("score", "speed") if isinstance(card, dict) and key in card)
    if (folder / RESULT).is_file():
        result = json.loads((folder / RESULT).read_text(encoding="utf-8"))
        if "val_within_5_percent" in result:
            return f"val: {result['val_within_5_percent']:.1f} % within 5 % of the diameter"
    return "bundled"
