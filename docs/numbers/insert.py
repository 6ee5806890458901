"""Insert stored results into the pages: ``python -m docs.numbers.insert [--check]``.

``rows.yaml`` beside this file says which row of which result file stands where; no number is typed. A table stands
between ``<!-- numbers: NAME -->`` and ``<!-- end -->``; ``--check`` changes nothing and fails where a page is stale.
The page of the dissertation's tables is written as a whole.
"""

import json
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from docs.numbers.dissertation import PAGE, page
from docs.numbers.freshness import unstored

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "benchmarks" / "results"


@dataclass(frozen=True)
class Row:
    """One line of a table."""

    what: str
    """What was measured, in a sentence."""
    file: str
    """Result file, below benchmarks/results."""
    match: dict[str, Any]
    """What the row of the file holds."""
    value: str = "value"
    """Key of the number, with dots for nested ones."""
    unit: str = "%"
    """% for a fraction, else what stands behind the number."""
    digits: int = 1
    """Behind the point."""
    command: str = ""
    """What measures it; the file's own command by default."""

    def stored(self) -> dict[str, Any]:
        """Return the row of the result file.

        Raises:
            LookupError: None or several match.
        """
        rows = json.loads((RESULTS / f"{self.file}.json").read_text(encoding="utf-8"))["rows"]
        found = [row for row in rows if all(row.get(key) == value for key, value in self.match.items())]
        if len(found) != 1:
            raise LookupError(f"rows.yaml: {self.what!r}: {len(found)} rows of {self.file}.json match {self.match}")
        for key in self.value.split(".")[:-1]:
            found[0] = found[0][key]
        return found[0]

    def cells(self) -> list[str]:
        """Return what stands in the table: what, number with interval, how many, command."""
        row, key = self.stored(), self.value.split(".")[-1]
        scale = 100.0 if self.unit == "%" else 1.0
        text = (
            f"**{scale * row[key]:.{self.digits}f} {self.unit}**"
            if self.unit != "%"
            else f"**{scale * row[key]:.1f} %**"
        )
        spread = row.get("interval") if key == "value" else row.get(f"{key}_by_frame")
        if spread is not None:
            text += f" [{scale * spread[0]:.{self.digits}f}, {scale * spread[1]:.{self.digits}f}]"
        command = self.command or json.loads((RESULTS / f"{self.file}.json").read_text(encoding="utf-8"))["command"]
        return [self.what, text, str(row.get("n") or row.get("episodes") or ""), f"`{_short(command)}`"]


@dataclass(frozen=True)
class Table:
    """A table of a page."""

    page: str
    """Path below the repository's root."""
    rows: tuple[Row, ...]
    """From top to bottom."""
    columns: tuple[str, ...] = ("what", "measured [95 %]", "n", "command")
    """Headings; the first so many cells are shown."""
    worst_first: bool = field(default=False)
    """Whether rows in % are sorted by their number."""

    def text(self) -> str:
        """Return the table in Markdown."""
        rows = list(self.rows)
        if self.worst_first:
            number = {row.what: row.stored()[row.value.split(".")[-1]] if row.unit == "%" else 1e9 for row in rows}
            rows.sort(key=lambda row: float(number[row.what]))
        width = len(self.columns)
        lines = [list(self.columns), ["---"] * width, *(row.cells()[:width] for row in rows)]
        return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


@dataclass(frozen=True)
class Unstored:
    """The sentence that names the suites without a stored result."""

    page: str = "docs/benchmark.md"
    """Path below the repository's root."""

    def text(self) -> str:
        """Return the sentence."""
        names = ", ".join(f"`{name}`" for name in unstored())
        return f"No full result is stored of {names}." if names else "Every suite has one."


def tables() -> dict[str, Table | Unstored]:
    """Return what is inserted, by name: the tables of ``rows.yaml``, and the suites without a stored result."""
    data = yaml.safe_load(Path(__file__).with_name("rows.yaml").read_text(encoding="utf-8"))
    made = {name: Table(**{**item, "rows": tuple(Row(**row) for row in item["rows"])}) for name, item in data.items()}
    return {**made, "unstored": Unstored()}


def pages() -> dict[str, str]:
    """Return the whole text of each page that holds numbers, by its path below the root, as it should be."""
    found = {PAGE: page()}
    for name, table in tables().items():
        before = found.get(table.page) or (ROOT / table.page).read_text(encoding="utf-8")
        found[table.page] = inserted(before, name, table.text())
    return found


def inserted(text: str, name: str, table: str) -> str:
    """Return a page with a table in its place.

    Raises:
        LookupError: The page has no such place.
    """
    place = re.compile(rf"(<!-- numbers: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(text):
        raise LookupError(f"no place '<!-- numbers: {name} -->' ... '<!-- end -->'")
    return place.sub(lambda found: f"{found.group(1)}{table}\n{found.group(2)}", text)


def _short(command: str) -> str:
    return command.removesuffix(" --write")


def main() -> int:
    """Write all pages; with ``--check`` only say which are not up to date."""
    stale = []
    for name, text in pages().items():
        path = ROOT / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            stale.append(name)
            if "--check" not in sys.argv:
                path.write_text(text, encoding="utf-8")
    print(f"{'stale' if '--check' in sys.argv else 'written'}: {', '.join(sorted(stale)) or 'nothing'}")
    return int("--check" in sys.argv and bool(stale))


if __name__ == "__main__":
    sys.exit(main())
