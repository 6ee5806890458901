"""Cards of the weights for any layout: what they do in each of nine, the worst first.

python -m benchmarks.front_ends.layout_card
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from benchmarks.front_ends.card import description
from benchmarks.front_ends.layouts import ENDINGS
from benchmarks.result import RESULTS, percent_cell
from warehouse_sim.resources import data_folder

_SHOWN = {
    "detector-depth": {"boxes AP50": "boxes"},
    "segmenter-depth": {"masks AP50, in boxes of detector-depth-warehouses": "masks"},
    "detector-rgb": {"boxes AP50": "boxes, RGB"},
    "densefusion-depth": {
        "docked, from pixels": "densefusion-depth, from pixels",
        "docked, ground-truth masks, verified": "densefusion-depth, ground-truth masks",
        "docked, ground-truth masks, alone": "densefusion-depth alone",
        "ceiling of the sensor": "ceiling",
    },
}
"""Columns of a card, by the estimator: heading, and method in layouts.json; rows are in order of the first."""


def main() -> None:
    """Write the cards."""
    rows = json.loads((RESULTS / "layouts.json").read_text(encoding="utf-8"))["rows"]
    for name in _SHOWN:
        model = data_folder("models") / f"{name}{ENDINGS['warehouses']}"
        if model.is_dir():
            print(f"output: {write(model, name, rows)}")


def write(model: Path, name: str, rows: Sequence[dict[str, Any]]) -> Path:
    """Write ``card.md`` and ``card.yaml`` of a model.

    Args:
        model: Folder of the model.
        name: What was trained.
        rows: Those of benchmarks/results/layouts.json.
    """
    columns, found = (
        _SHOWN[name],
        {(row["layout"], row["method"]): row for row in rows if row["weights"] in ("warehouses", "")},
    )
    first = next(iter(columns.values()))
    layouts = sorted((row["value"], layout) for (layout, method), row in found.items() if method == first)
    lines = [
        f"# {model.name}",
        "",
        *description(model),
        "",
        "## Scores",
        "",
        "Scenes that nothing was trained on (`benchmarks/front_ends/layouts.py`), with the rig of each recipe, in % "
        "with 95 % intervals over scenes; what is missed counts. The worst layout stands first.",
        "",
        "| layout | " + " | ".join(columns) + " | n |",
        "|---|" + "---|" * (len(columns) + 1),
        *(
            f"| `{layout}` | "
            + " | ".join(percent_cell(found.get((layout, method))) for method in columns.values())
            + f" | {found[layout, first]['n']} |"
            for _, layout in layouts
        ),
        "",
        "## Limits",
        "",
        "- Trained and scored on synthetic images of this package only.",
        "- Boxes and masks: pallets within 10 m of which a tenth is visible. Docked: of pallets that a truck can take.",
    ]
    worst, where = layouts[0]
    score = f"{where}, the worst of {len(layouts)} layouts: {next(iter(columns))} {100 * worst:.1f} %"
    (model / "card.yaml").write_text(yaml.safe_dump({"score": score}, sort_keys=False), encoding="utf-8")
    path = model / "card.md"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


if __name__ == "__main__":
    main()
