"""What is known of bundled weights: score and speed as their card states them."""

import json
from pathlib import Path

from warehouse_sim.yaml_file import read_yaml

CARD, RESULT = "card.yaml", "result.json"


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
