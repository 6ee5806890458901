"""A result as it is stored: the machine it was measured on, the command that renews it, rows of numbers."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.machine import processor
from warehouse_sim.dataset.manifest import package_versions
from warehouse_sim.render import open_renderer

RESULTS = Path(__file__).parents[1] / "results"


def write_result(path: Path, command: str, rows: Sequence[dict[str, Any]], **more: Any) -> None:
    """Write a result and print where it is.

    Args:
        path: The JSON file.
        command: What renews it.
        rows: One measurement each, with a ``name``.
        more: What else is to be known, such as the data; ``machine`` where it is not this one.
    """
    result = {"machine": more.pop("machine", None) or machine(), "command": command, **more, "rows": list(rows)}
    path.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    print(f"output: {path}")


def beside_stored(path: Path, rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return rows in place of those of their names in a stored result, whose others stay; new ones come last."""
    old = json.loads(path.read_text(encoding="utf-8"))["rows"] if path.is_file() else []
    new = {row["name"]: row for row in rows}
    kept = [new.pop(row["name"], row) for row in old]
    return kept + list(new.values())


def machine() -> dict[str, Any]:
    """Return what the numbers depend on besides the code."""
    with open_renderer("raster") as renderer:
        description = renderer.description
    return {"processor": processor(), "cores": os.cpu_count(), "renderer": description, "packages": package_versions()}


def rounded(value: Any) -> Any:
    """Return ``value`` with four digits a number, in lists and mappings too: more than these measurements can say."""
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(item) for item in value]
    return value
