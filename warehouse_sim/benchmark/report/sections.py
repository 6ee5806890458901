"""What the page shows of each suite, ready for the template."""

import json
from collections.abc import Sequence
from typing import Any

from warehouse_sim.benchmark.report.board import Board, Place
from warehouse_sim.benchmark.report.looks import Look, family_of, looks_of
from warehouse_sim.benchmark.report.markdown import HOW, TITLES, fraction_text, size_lines
from warehouse_sim.benchmark.report.names import metric_title
from warehouse_sim.benchmark.report.panels import Panel, panels
from warehouse_sim.benchmark.result import SuiteResult
from warehouse_sim.benchmark.rows.row import Row

_AS = "as "


def title_of(result: SuiteResult) -> str:
    """Return the suite with its size."""
    return f"{result.suite} (quick)" if result.quick else result.suite


def suite_section(result: SuiteResult, found: Sequence[Board], number: int, alone: bool) -> dict[str, Any]:
    """Show a suite: leaderboards, charts, confusions, and what it was made of.

    Args:
        result: Of the suite.
        found: Its leaderboards.
        number: Its place on the page, which distinguishes its charts from those of other suites.
        alone: Whether nothing else is on the page; else charts of other metrics and groups are only counted.
    """
    looks = looks_of(result.estimators)
    drawn = [(panel, f"s{number}-c{place}-") for place, panel in enumerate(panels(result))]
    return {
        "title": title_of(result),
        "number": number,
        "question": result.question,
        "size": list(size_lines(result)),
        "boards": [_board(item, looks) for item in found],
        "key": _key(result, looks) if drawn else [],
        "charts": [_drawn(panel, prefix) for panel, prefix in drawn if panel.first],
        "more": [_drawn(panel, prefix) for panel, prefix in drawn if alone and not panel.first],
        "folded": 0 if alone else sum(not panel.first for panel, _ in drawn),
        "confusions": _confusions(result),
        "left_out": result.left_out,
        "notes": result.notes,
        "facts": _facts(result),
    }


def shown_cell(row: Row) -> dict[str, Any]:
    """Return what a cell shows of a fraction: text, interval and the numbers of its bar."""
    low, high = row.interval
    return {
        "text": fraction_text(row.value),
        "interval": f"{100 * low:.0f}–{100 * high:.0f}",
        "value": 100.0 * row.value,
        "low": 100.0 * low,
        "high": 100.0 * high,
        "n": row.n,
    }


def _drawn(panel: Panel, prefix: str) -> tuple[str, str]:
    return panel.title, panel.draw(prefix)


def _board(item: Board, looks: dict[str, Look]) -> dict[str, Any]:
    named = [TITLES[item.table], item.condition, *([] if item.group == "all" else [item.group])]
    return {
        "title": ", ".join(named),
        "how": HOW[item.table],
        "columns": [metric_title(metric) for metric in item.metrics],
        "lines": [_line(item, place, looks[place.name]) for place in item.places],
    }


def _line(item: Board, place: Place, look: Look) -> dict[str, Any]:
    first = place.cells.get(item.metric) or next(iter(place.cells.values()))
    cells = [place.cells.get(metric) for metric in item.metrics]
    return {
        "name": place.name,
        "kind": place.kind,
        "rank": place.rank,
        "leads": place.leads,
        "look": look,
        "cells": [None if row is None else shown_cell(row) | {"other": row.n != first.n} for row in cells],
        "n": first.n,
        "over": first.over,
    }


def _key(result: SuiteResult, looks: dict[str, Look]) -> list[tuple[Look, str]]:
    """Return all estimators with a number, each training once."""
    drawn = {row.estimator for row in result.rows}
    found: dict[str, Look] = {}
    for item in result.estimators:
        if item.name in drawn:
            found.setdefault(family_of(item), looks[item.name])
    return [(look, name) for name, look in found.items()]


def _confusions(result: SuiteResult) -> list[dict[str, Any]]:
    """Return a table for each detector and condition: a line for each true class, a column for each it was found as.

    What of all that was found is on nothing stands below, since it is a fraction of something else.
    """
    rows = [row for row in result.rows if row.table == "confusion"]
    tables = []
    for estimator, condition in dict.fromkeys((row.estimator, row.condition) for row in rows):
        mine = [row for row in rows if (row.estimator, row.condition) == (estimator, condition)]
        false = [row for row in mine if row.metric == f"{_AS}nothing"]
        fractions = [row for row in mine if row not in false]
        columns = sorted({row.metric for row in fractions}, key=lambda name: (name == f"{_AS}missed", name))
        lines = []
        for true in dict.fromkeys(row.group for row in fractions):
            cells = {row.metric: row for row in fractions if row.group == true}
            shown = [shown_cell(cells[name]) if name in cells else None for name in columns]
            lines.append({"name": true, "n": next(iter(cells.values())).n, "cells": shown})
        tables.append(
            {
                "title": f"{estimator}, {condition}",
                "columns": [name.removeprefix(_AS) for name in columns],
                "lines": lines,
                "false": [shown_cell(row) for row in false],
            }
        )
    return tables


def _facts(result: SuiteResult) -> dict[str, str]:
    weights = {item.name: item.weights_sha256 for item in result.estimators if item.weights_sha256}
    return {
        "Command": result.command,
        "Seconds": f"{result.seconds:g}; {result.reused} scores of a run before were used again",
        "Machine": json.dumps(result.machine, ensure_ascii=False),
        "Weights": ", ".join(f"{name} {digest}" for name, digest in weights.items()) or "none",
    }
