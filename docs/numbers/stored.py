"""Numbers of benchmarks/results: where each lies, what is stored there, and paired effects between two of them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks" / "results"
Given = str | Mapping[str, str]
"""What a file says of a place: an estimator, or keys of a row and ``suite``."""
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

    suite: str
    """Whose result it is in."""
    match: dict[str, str]
    """What the row holds."""
    known: dict[str, str]
    """What a reader knows of the row already."""

    @property
    def file(self) -> str:
        """Below benchmarks/results, without its ending."""
        return f"suites/{self.suite}"

    @property
    def command(self) -> str:
        """What measures it."""
        return f"warehouse-sim bench {self.suite}"

    def differs(self, *others: "Place") -> str:
        """Return its name: estimator, and what a reader does not know or the others do not share."""
        own, *rest = ({"suite": item.suite, **item.match} for item in (self, *others))
        names = [
            own[key]
            for key in ("suite", "condition", "group", "metric")
            if own[key] != self.known.get(key, own[key]) or any(item[key] != own[key] for item in rest)
        ]
        return ", ".join(dict.fromkeys([f"`{own['estimator']}`", *names]))


def place_of(at: Mapping[str, str], *layers: Given) -> Place:
    """Return a place from what is known of all its neighbours (``at``) and from what else is said of it."""
    known = {**_PLAIN, **at}
    keys = dict(known)
    for layer in layers:
        keys |= {"estimator": layer} if isinstance(layer, str) else layer
    return Place(keys.pop("suite"), keys, known)


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
    return _number(found[0])


def effect(one: Place, other: Place) -> Number | None:
    """Return by how much one lies above the other on the same ground truths, where a suite stored that."""
    if one.suite != other.suite or one.match["metric"] != other.match["metric"]:
        return None
    for first, second, turned in ((one, other, False), (other, one, True)):
        for row in read(one.file)["rows"]:
            if row["table"] == "effects" and row["metric"] == one.match["metric"] and _pairs(row, first, second):
                found = _number(row)
                return found.swapped if turned else found
    return None


def _number(row: Mapping[str, Any]) -> Number:
    low, high = row["interval"]
    return Number(row["value"], low, high, row["n"], row["trainings"])


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
