"""The table of all bundled estimators in models/README.md, between its two marks."""

from pathlib import Path
from typing import Any

from benchmarks.result import percent_cell
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.resources import data_folder

COMMAND = "python -m benchmarks.estimators --write"
END = "<!-- end of table -->"
_COLUMNS = (
    ("industrial", "add_10pct", "industrial: ADD < 10 % d"),
    ("industrial", "add_5pct", "industrial: ADD < 5 % d"),
    ("industrial", "dock_0mm_2_7m", "industrial: docked, 2-7 m"),
    ("mixed_pallets", "add_10pct", "mixed pallets: ADD < 10 % d"),
    ("mixed_pallets", "add_5pct", "mixed pallets: ADD < 5 % d"),
    ("mixed_pallets", "dock_0mm_2_7m", "mixed pallets: docked, 2-7 m"),
    ("industrial_cartons_test", "add_10pct", "cartons: ADD < 10 % d"),
    ("industrial_cartons_test", "add_shape_10pct", "in shape"),
    ("mixed_cartons_test", "add_10pct", "mixed cartons: ADD < 10 % d"),
    ("mixed_cartons_test", "add_shape_10pct", "in shape"),
)


def as_markdown(rows: list[dict[str, Any]]) -> str:
    """Return the rows of a result as a Markdown table: a line a method and setting, shares in % with intervals."""
    lines = [
        "| | | " + " | ".join(title for _, _, title in _COLUMNS) + " |",
        "|---|---|" + "---|" * len(_COLUMNS),
    ]
    by_key = {
        (row["method"], row["setting"], row["data"], row["metric"]): row for row in rows if row["split"] == "test"
    }
    methods = [name for name in ESTIMATORS.names() if any(row["method"] == name for row in rows)]
    for method in methods:
        settings = list(dict.fromkeys(row["setting"] for row in rows if row["method"] == method))
        for setting in settings:
            cells = [percent_cell(by_key.get((method, setting, data, metric))) for data, metric, _ in _COLUMNS]
            name = f"[`{method}`]({method}/card.md)" if setting == settings[0] else ""
            lines.append(f"| {name} | {setting} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def write(rows: list[dict[str, Any]]) -> Path:
    """Put the table into models/README.md."""
    return replace_table(data_folder("models") / "README.md", COMMAND, as_markdown(rows))


def replace_table(path: Path, command: str, table: str) -> Path:
    """Put ``table`` (Markdown) between the marks of ``command`` in the document ``path``.

    Raises:
        ValueError: The document has no such marks.
    """
    start = f"<!-- table: {command} -->"
    before, found, rest = path.read_text(encoding="utf-8").partition(start)
    _, ended, after = rest.partition(END)
    if not found or not ended:
        raise ValueError(f"{path}: has no lines {start!r} and {END!r}")
    path.write_text(f"{before}{start}\n\n{table}\n\n{END}{after}", encoding="utf-8")
    return path
