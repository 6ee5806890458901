"""What there is to choose from: each estimator's inputs and size, and how well its bundled weights do."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warehouse_sim.estimators import ESTIMATORS, is_trainable
from warehouse_sim.resources import model_dir, model_names
from warehouse_sim.yaml_file import read_yaml

CARD, RESULT = "card.yaml", "result.json"


@dataclass(frozen=True)
class Overview:
    """One estimator in a few words."""

    name: str
    inputs: str
    """What it reads of an observation; empty when it does not say."""
    parameters: dict[str, int]
    """Number of weights by size, for one object; none where it has no sizes."""
    bundled: str
    """Score and speed of the bundled weights, or that none are needed; empty when there are none."""


def overview(name: str) -> Overview:
    """Return what is known of a registered estimator, which may say it in ``inputs`` and ``parameters()``.

    Raises:
        UnknownNameError: No such estimator.
    """
    registered: Any = ESTIMATORS.get(name)
    counted = getattr(registered, "parameters", None)
    if name in model_names():
        bundled = describe_model(model_dir(name))
    else:
        bundled = "" if is_trainable(registered) else "needs no training"
    inputs = getattr(registered, "inputs", "")
    return Overview(name, inputs if isinstance(inputs, str) else "", counted() if counted else {}, bundled)


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
