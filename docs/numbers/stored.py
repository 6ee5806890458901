"""Numbers of benchmarks/results: where each lies, what is stored there, and paired effects between two of them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks" / "results"
Given = str | Mapping[str, Any]
"""What a file says of a place: an estimator, or keys of a row, with ``suite`` or ``file``."""
_PLAIN = {"table": "scores", "group": "all", "against": ""}


@dataclass(frozen=True)
class Number:
    """A stored fraction with its interval."""

    value: float
    low: float
    high: float
    n: int | None = None
    trainings: int = 0

    @property
    def swapped(self) -> "Number":
        """The effect the other way round."""
        return Number(-self.value, -self.high, -self.low, self.n, self.trainings)


@dataclass(frozen=True)
class Place:
    """Where a number lies."""

    file: str
    """Below benchmarks/results, without its ending."""
    match: dict[str, str]
    """What the row holds."""
    value: str = "value"
    """Key of the number, with dots for nested ones."""
    known: dict[str, str] = field(default_factory=dict)
    """What a reader knows of the row already."""

    @property
    def command(self) -> str:
        """What measures it: a suite's own command, or that of the stored file."""
        if self.file.startswith("suites/"):
            return f"warehouse-sim bench {self.file.removeprefix('suites/')}"
        return str(read(self.file).get("command", ""))

    def differs(self, *others: "Place") -> str:
        """Return its name: estimator, and what a reader does not know or the others do not share."""
        who = self.match.get("estimator", self.match.get("name", ""))
        rest = {"suite": self.file.removeprefix("suites/"), **self.match}
        names = []
        for key in ("suite", "condition", "group", "metric"):
            theirs = {item.file.removeprefix("suites/") if key == "suite" else item.match.get(key) for item in others}
            if key in rest and (rest[key] != self.known.get(key, rest[key]) or theirs - {rest[key]}):
                names.append(rest[key])
        return ", ".join(dict.fromkeys([f"`{who}`", *names]))


def place_of(*layers: Given) -> Place:
    """Return a place from the most general to the most special of what is said of it; a file begins from nothing."""
    keys: dict[str, Any] = dict(_PLAIN)
    for layer in layers:
        found = {"estimator": layer} if isinstance(layer, str) else layer
        keys = dict(found) if "file" in found else {**keys, **found}
    file = keys.pop("file", None) or f"suites/{keys.pop('suite')}"
    value = keys.pop("value", "value")
    first = layers[0]
    known = {} if isinstance(first, str) else {key: str(first[key]) for key in first}
    return Place(file, keys, value, {**_PLAIN, **known})


@cache
def read(file: str) -> dict[str, Any]:
    """Return a result file; of one that is not stored nothing."""
    path = RESULTS / f"{file}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def rows(place: Place, *but: str) -> list[dict[str, Any]]:
    """Return the stored rows of a place, whatever they hold under some keys."""
    wanted = {key: value for key, value in place.match.items() if key not in but}
    return [row for row in read(place.file).get("rows", []) if all(row.get(key) == wanted[key] for key in wanted)]


def number(place: Place) -> Number | None:
    """Return what is stored at a place, None where nothing is.

    Raises:
        LookupError: Several rows match.
    """
    found = rows(place)
    if len(found) > 1:
        raise LookupError(f"{len(found)} rows of {place.file}.json match {place.match}")
    if not found:
        return None
    row, (*outer, key) = found[0], place.value.split(".")
    for name in outer:
        row = row[name]
    low, high = row["interval"]
    return Number(row[key], low, high, row.get("n"), found[0].get("trainings", 0))


def effect(one: Place, other: Place) -> Number | None:
    """Return by how much one lies above the other on the same ground truths, where a suite stored that."""
    if one.file != other.file or "metric" not in one.match or one.match["metric"] != other.match.get("metric"):
        return None
    for first, second, turned in ((one, other, False), (other, one, True)):
        for row in read(one.file)["rows"]:
            if row["table"] == "effects" and row["metric"] == one.match["metric"] and _pairs(row, first, second):
                low, high = row["interval"]
                found = Number(row["value"], low, high, row["n"], row["trainings"])
                return found.swapped if turned else found
    return None


def _pairs(row: Mapping[str, Any], first: Place, second: Place) -> bool:
    one, other = first.match, second.match
    group = one["group"]
    if one["table"] != "scores" or group != other["group"] or row["estimator"] != one["estimator"]:
        return False
    if ("," in row["group"]) != (group != "all") or (group != "all" and not row["group"].endswith(f", {group}")):
        return False
    if one["condition"] == other["condition"]:
        return bool(row["condition"] == one["condition"] and row["against"] == other["estimator"])
    same = one["estimator"] == other["estimator"]
    return bool(same and row["condition"] == one["condition"] and row["against"] == other["condition"])
