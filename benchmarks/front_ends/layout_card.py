"""Cards of the weights for any layout: what they do in each of nine, the worst first.

python -m benchmarks.front_ends.layout_card
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from benchmarks.front_ends.layouts import ENDINGS
from benchmarks.speed.result import RESULTS
from trainings.cards import percent_cell
from trainings.data import TARGETS
from trainings.facts import description
from warehouse_sim.resources import data_folder

_PIXELS, _ALONE = "densefusion-depth, from pixels", "densefusion-depth alone"
_SHOWN = {
    "detector-depth": {
        "boxes AP50": ("boxes", ""),
        "with the help of detector-rgb-warehouses": ("boxes, depth and RGB", ""),
    },
    "segmenter-depth": {"masks AP50, in boxes of detector-depth-warehouses": ("masks", "")},
    "segmenter-rgb": {
        "masks AP50, after segmenter-depth-warehouses, in boxes of detector-depth-warehouses": (
            "masks, depth and RGB",
            "",
        ),
        "of segmenter-depth-warehouses alone": ("masks", ""),
    },
    "detector-rgb": {
        "boxes AP50 of whole pallets": ("boxes, RGB", ""),
        "of people": ("boxes, RGB", "person"),
        "of trucks": ("boxes, RGB", "forklift"),
        "of pallets, helping detector-depth-warehouses": ("boxes, depth and RGB", ""),
    },
    "densefusion-depth": {
        "ADD < 10 % d, from pixels": (_PIXELS, ""),
        "docked, from pixels": (_PIXELS, "docked"),
        "the same, whatever kind the pallet is called": (_PIXELS, "docked_any_name"),
        "docked, ground-truth masks, alone": (_ALONE, "docked"),
        "docked, ceiling of the sensor": ("ceiling", "docked"),
        "ADD < 10 % d, ground-truth masks, alone, to 7 m, 30 % visible": (_ALONE, "add_10pct_near"),
    },
}
"""Columns of a card, by the estimator: heading, method in layouts.json, key in its row; rows are in order of the first.
"""


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
    first, _ = next(iter(columns.values()))
    of_first = {layout: row for (layout, method), row in found.items() if method == first}
    layouts = sorted(of_first, key=lambda layout: of_first[layout]["value"])
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
            + " | ".join(_cell(found.get((layout, method)), part) for method, part in columns.values())
            + f" | {of_first[layout]['n']} |"
            for layout in layouts
        ),
        "",
        "## Limits",
        "",
        "- Trained and scored on synthetic images of this package only.",
        "- Boxes and masks: pallets within 10 m of which a tenth is visible. Docked: of pallets that a truck can take.",
    ]
    worst = 100 * of_first[layouts[0]]["value"]
    score = f"{layouts[0]}, the worst of {len(layouts)} layouts: {next(iter(columns))} {worst:.1f} %"
    (model / "card.yaml").write_text(yaml.safe_dump({"score": score}, sort_keys=False), encoding="utf-8")
    path = model / "card.md"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _cell(row: dict[str, Any] | None, key: str) -> str:
    """Return a cell; "-" where nothing was measured, or where none is evaluated. People and trucks are counted."""
    part = None if row is None else row.get(key) if key else row
    count = f", {part['n']} seen" if part and key in TARGETS else ""
    return percent_cell(part) + count


if __name__ == "__main__":
    main()
