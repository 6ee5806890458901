"""The page of the dissertation's tables and figures, from dissertation.yaml and the stored results."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from docs.numbers.freshness import lines
from docs.numbers.stored import Place, number, place_of, read
from docs.numbers.verdicts import OPEN, Boxes, Outcome, decide, percent, values_of

PAGE = "docs/dissertation.md"
MISSING = "no stored result"


@dataclass(frozen=True)
class Section:
    """A table or figure of the dissertation."""

    title: str
    theirs: str
    """On what the dissertation measured."""
    rows: tuple[Mapping[str, Any], ...]
    """``what``; ``theirs`` or ``objects`` (a box plot of ``linemod``); ``none`` (why there is none of ours), ``fact``
    (a file and keys of the machine that it states), ``cells`` (a place for each column), or keys of one place."""
    claims: tuple[Mapping[str, Any], ...]
    """``says`` and ``tests``, or ``because``: why no number can decide."""
    at: Mapping[str, Any] | None = None
    """Where its rows lie unless a column or row says otherwise."""
    columns: tuple[Mapping[str, Any], ...] = ({"head": "ours"},)
    """``head`` and what all places of the column share."""
    boxes: Boxes | None = None
    """Whether cells are box plots over objects."""
    note: str = ""
    command: str = ""
    """What measures it; by default that of all its places."""

    def places(self, row: Mapping[str, Any]) -> list[Place]:
        """Return the place of each cell of a row; none where it has no number."""
        if "none" in row or "fact" in row:
            return []
        own = {key: value for key, value in row.items() if key not in ("what", "theirs", "objects", "cells")}
        cells = row.get("cells", [own] * len(self.columns))
        shared = [{key: value for key, value in column.items() if key != "head"} for column in self.columns]
        return [place_of(self.at or {}, *both) for both in zip(shared, cells, strict=True)]

    def outcome(self, claim: Mapping[str, Any]) -> Outcome:
        """Return what the stored numbers say of one of its claims."""
        if "because" in claim:
            return Outcome(OPEN, claim["because"])
        return decide(claim["tests"], self.at or {}, self.boxes)


@dataclass(frozen=True)
class Published:
    """What ``dissertation.yaml`` holds."""

    intro: str
    """What stands above the sections, in Markdown."""
    linemod: Mapping[str, list[float]]
    """Accuracy of each object of LINEMOD by method (%)."""
    sections: tuple[Section, ...]


def published() -> Published:
    """Return what the dissertation measured, and where ours lies."""
    data = yaml.safe_load(Path(__file__).with_name("dissertation.yaml").read_text(encoding="utf-8"))
    found = []
    for item in data["sections"]:
        boxes = item.pop("boxes", None)
        own = None if boxes is None else Boxes(tuple(boxes["leave"]), boxes["least"])
        found.append(Section(**item, boxes=own))
    return Published(data["intro"].strip(), data["linemod"], tuple(found))


def page() -> str:
    """Return the page."""
    whole = published()
    parts = ["# The dissertation, table by table", whole.intro, _summary(whole.sections)]
    parts += [_section(item, whole.linemod) for item in whole.sections]
    parts += [_missing(whole.sections), _freshness(whole.sections)]
    return "\n\n".join(parts) + "\n"


def _summary(found: Sequence[Section]) -> str:
    rows = [["table or figure", "sentence", "on our data"], ["---"] * 3]
    for item in found:
        rows += [[item.title, claim["says"], f"**{item.outcome(claim).verdict}**"] for claim in item.claims]
        rows += [] if item.claims else [[item.title, "no sentence", "-"]]
    return "## Summary\n\n" + _table(rows)


def _section(item: Section, linemod: Mapping[str, list[float]]) -> str:
    heads = ["", f"dissertation: {item.theirs}", *(column["head"] for column in item.columns)]
    rows = [heads, ["---"] * len(heads), *(_row(item, row, linemod) for row in item.rows)]
    parts = [f"## {item.title}", *filter(None, [item.note]), _table(rows)]
    claims = []
    for claim in item.claims:
        outcome = item.outcome(claim)
        claims.append(f"- *{claim['says']}* This **{outcome.verdict}**: {outcome.why}.")
    parts += ["\n".join(claims)] if claims else []
    commands = item.command or "`, `".join(_commands(item))
    return "\n\n".join([*parts, *([f"Command: `{commands}`"] if commands else [])])


def _row(item: Section, row: Mapping[str, Any], linemod: Mapping[str, list[float]]) -> list[str]:
    theirs = _box(np.array(linemod[row["objects"]])) if "objects" in row else row["theirs"]
    return [row["what"], theirs, *_ours(item, row)]


def _ours(item: Section, row: Mapping[str, Any]) -> list[str]:
    if "none" in row:
        return [row["none"], *([""] * (len(item.columns) - 1))]
    if "fact" in row:
        file, *keys = row["fact"]
        found: Any = read(file)["machine"]
        for key in keys:
            found = found[key]
        return [str(found)]
    return [_cell(place, item.boxes) for place in item.places(row)]


def _cell(place: Place, boxes: Boxes | None) -> str:
    found = number(place)
    if found is None:
        return MISSING
    if boxes is not None:
        values = values_of(place, boxes)
        return f"{_box(100 * np.array(list(values.values())))} ({len(values)} geometries)"
    trainings = f", {found.trainings} trainings" if found.trainings > 1 else ""
    count = f" (n={found.n}{trainings})" if found.n else ""
    return f"**{percent(found).replace(' ', '** ', 1)}{count}"


def _box(values: np.ndarray) -> str:
    least, low, middle, high, largest = np.percentile(values, [0, 25, 50, 75, 100])
    return f"{least:.1f}, {low:.1f}, {middle:.1f}, {high:.1f}, {largest:.1f}"


def _commands(item: Section) -> list[str]:
    places = [place for row in item.rows for place in item.places(row)]
    return list(dict.fromkeys(place.command for place in places))


def _without(found: Sequence[Section]) -> Iterator[tuple[str, str, str]]:
    """Yield command, table or figure and row of each number that is not stored."""
    for item in found:
        for row in item.rows:
            for place in item.places(row):
                if number(place) is None:
                    yield place.command, item.title.partition(":")[0], row["what"]


def _missing(found: Sequence[Section]) -> str:
    by_command: dict[str, dict[str, list[str]]] = {}
    for command, title, what in _without(found):
        by_command.setdefault(command, {}).setdefault(title, []).append(what)
    text = "## Rows without a stored result\n\n"
    if not by_command:
        return f"{text}None."
    listed = [
        [f"`{command}`", ". ".join(f"**{title}**: {'; '.join(dict.fromkeys(whats))}" for title, whats in of.items())]
        for command, of in by_command.items()
    ]
    return text + _table([["command that stores them", "rows"], ["---"] * 2, *listed])


def _freshness(found: Sequence[Section]) -> str:
    places = [place for item in found for row in item.rows for place in item.places(row)]
    suites = dict.fromkeys(place.suite for place in places)
    head = [
        "suite",
        "stored",
        "by version",
        "in the suite, not in the result",
        "made with other weights or settings than now",
    ]
    text = (
        "## How old the stored rows are\n\nThe last column compares SHA-256 digests of weights and settings; a renamed "
        "setting changes one, too. The commands above make data and rows again, with the version that runs them."
    )
    return f"{text}\n\n{_table([head, ['---'] * len(head), *lines(list(suites))])}"


def _table(rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)
