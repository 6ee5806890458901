"""Answers as they are kept: a line of JSON each, so that a run that was stopped goes on where it was."""

import json
from pathlib import Path
from typing import Any

Row = dict[str, Any]


class Kept:
    """Rows in a file of JSON lines, by key; a line that a stopped run left unfinished is passed over."""

    def __init__(self, path: Path) -> None:
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        self._rows: dict[str, Row] = {}
        for line in text.splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            self._rows[row["key"]] = row
        self._is_cut = not text.endswith("\n") and bool(text)

    def __contains__(self, key: str) -> bool:
        return key in self._rows

    def __getitem__(self, key: str) -> Row:
        return self._rows[key]

    def add(self, key: str, row: Row) -> Row:
        """Keep a row and return it."""
        self._rows[key] = kept = {"key": key, **row}
        with self._path.open("a", encoding="utf-8") as file:
            # The next row would otherwise be lost with the one that was cut off.
            file.write("\n" * self._is_cut + json.dumps(kept) + "\n")
        self._is_cut = False
        return kept
