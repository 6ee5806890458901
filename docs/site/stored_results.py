"""A page for each file of benchmarks/results: machine, command and every row, written when the site is built."""

import json
from pathlib import Path
from typing import Any

_LAST = ("interval", "n")
_MOST_COLUMNS = 12
"""More are put together as text, so that a table stays readable."""
_LONGEST = 240
"""Characters of a cell; what is longer is in the file alone."""


def pages(results: Path) -> dict[str, str]:
    """Return the pages in Markdown by their place below the folder ``results``, the contents last.

    Args:
        results: The folder benchmarks/results.
    """
    files = sorted(results.glob("*.json"))
    found = {f"{path.stem}.md": page(path) for path in files}
    listed = "\n".join(f"| [{path.stem}]({path.stem}.md) | `{_command(_read(path))}` |" for path in files)
    names = "\n".join(path.stem for path in files)
    found["index.md"] = (
        "# Stored measurements\n\nEvery file of `benchmarks/results`, row by row. Suites are on the "
        "[leaderboards](../../leaderboards.md).\n\n"
        f"| file | command |\n|---|---|\n{listed}\n\n```{{toctree}}\n:hidden:\n\n{names}\n```\n"
    )
    return found


def page(path: Path) -> str:
    """Return the page of one file."""
    data = _read(path)
    rows = data.get("rows", [])
    parts = [f"# {path.stem}\n\nCommand: `{_command(data)}`\n"]
    rest = [f"- {key}: {_text(value)}" for key, value in data.items() if key not in ("rows", "command")]
    parts += ["<details><summary>Machine and settings</summary>\n", *rest, "\n</details>"]
    columns = _columns(rows)
    parts.append(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for row in rows:
        cells = {key: value for key, value in row.items() if key in columns}
        if "more" in columns:
            cells["more"] = {key: value for key, value in row.items() if key not in columns}
        texts = [_text(cells.get(column, "")) for column in columns]
        parts.append(f"| {' | '.join(text if len(text) <= _LONGEST else '(in the file)' for text in texts)} |")
    return "\n".join(parts) + "\n"


def _columns(rows: list[dict[str, Any]]) -> list[str]:
    names = list(dict.fromkeys(key for row in rows for key in row))
    names.sort(key=lambda name: (name != "name", name in _LAST))
    if len(names) <= _MOST_COLUMNS:
        return names
    counts = {name: sum(name in row for row in rows) for name in names}
    most = sorted(names, key=lambda name: -counts[name])[: _MOST_COLUMNS - 1]
    return [*(name for name in names if name in most), "more"]


def _read(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def _command(data: dict[str, Any]) -> str:
    return str(data.get("command", "")).replace("`", "")


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(_text(item) for item in value)
    if isinstance(value, dict):
        return "; ".join(f"{key}: {_text(item)}" for key, item in value.items())
    text = " ".join(str(value).split())
    for character in "\\|<>*_[]#`$":
        text = text.replace(character, f"&#{ord(character)};")
    return text
