"""Charts and leaderboards of suites, drawn from result files alone: nothing is generated, predicted or scored."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.report.board import Board, Place, boards, first_boards, standings
from warehouse_sim.benchmark.report.looks import Look, family_of, looks_of, metric_title
from warehouse_sim.benchmark.report.markdown import HOW, TITLES, cell_text, seconds_text, size_lines
from warehouse_sim.benchmark.report.panels import panels
from warehouse_sim.benchmark.result import SuiteResult, read_result
from warehouse_sim.benchmark.rows.row import SECONDS, Row
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.viewing.page.template import filled
from warehouse_sim.errors import DatasetError, EvaluationError
from warehouse_sim.evaluation.report.metric_help import help_of
from warehouse_sim.evaluation.report.numbers import percent
from warehouse_sim.output import make_folder, write_bytes

__all__ = ["is_results", "write_suite_report"]

_RESULTS = "results"
_MARKDOWN = ".md"
_QUICK = "-quick"


def is_results(path: Path) -> bool:
    """Return whether a path is a JSON file, or a folder that holds results of suites, itself or in ``results``."""
    return path.suffix == ".json" or bool(_files(path))


def write_suite_report(paths: Sequence[Path], out: Path) -> Path:
    """Write a page of charts and leaderboards of results, or, to a name that ends in .md, the leaderboards alone.

    Args:
        paths: Results, or folders of them; of a folder, a quick result is left out where the full one lies beside it.
        out: The file to write.

    Returns:
        ``out``.

    Raises:
        EvaluationError: A file is no result, or two are of the same suite and size.
        MissingPackageError: plotly or jinja2 is not installed.
    """
    results = {title_of(result): result for result in map(read_result, _chosen(paths))}
    text = _markdown(results) if out.suffix == _MARKDOWN else suite_page(results)
    make_folder(out.parent)
    write_bytes(out, text.encode("utf-8"))
    return out


def suite_page(results: Mapping[str, SuiteResult]) -> str:
    """Return the page of results by title."""
    boards_of = {title: boards(result) for title, result in results.items()}
    return filled(
        __package__,
        "suites.html.j2",
        title=next(iter(results)) if len(results) == 1 else "warehouse-sim benchmark",
        suites=[suite_section(result, boards_of[title], len(results) == 1) for title, result in results.items()],
        across=_across(first_boards(boards_of)),
    )


def _chosen(paths: Sequence[Path]) -> list[Path]:
    found = [file for path in paths for file in ([path] if path.suffix == ".json" else _files(path))]
    unique = list({os.path.realpath(file): file for file in found}.values())
    titles = [title_of(read_result(file)) for file in unique]
    for number, (title, file) in enumerate(zip(titles, unique, strict=True)):
        if title in titles[:number]:
            raise EvaluationError(f"{file}: is of {title}, as {unique[titles.index(title)]} is; give one of them")
    return unique


def _files(folder: Path) -> list[Path]:
    """Return the results in a folder in the order of their names, without quick ones that have a full one beside."""
    for place in (folder, folder / _RESULTS):
        files = [file for file in sorted(place.glob("*.json")) if _is_result(file)]
        names = {file.stem for file in files}
        if files:
            return [file for file in files if not (file.stem.endswith(_QUICK) and file.stem[: -len(_QUICK)] in names)]
    return []


def _is_result(file: Path) -> bool:
    try:
        data = read_json(file)
    except DatasetError:
        return False
    return isinstance(data, dict) and {"suite", "question", "rows"} <= set(data)


def _across(found: Mapping[str, Board]) -> dict[str, Any] | None:
    lines = standings(found) if len(found) > 1 else []
    if not lines:
        return None
    return {
        "heads": [
            (suite, metric_title(board.metric), board.condition, help_of(board.metric))
            for suite, board in found.items()
        ],
        "lines": [
            {
                "name": item.name,
                "kind": item.kind,
                "leads": "" if item.kind else f"{item.leads} of {len(item.places)}",
                "cells": [
                    {**shown_cell(item.places[suite].cells[board.metric]), "leads": item.places[suite].leads}
                    if suite in item.places
                    else None
                    for suite, board in found.items()
                ],
            }
            for item in lines
        ],
    }


def _markdown(results: Mapping[str, SuiteResult]) -> str:
    lines = ["# Leaderboards", "", "Written by `warehouse-sim report`; by the headline number of each suite.", ""]
    for title, result in results.items():
        lines += [f"## {_cell(title)}", "", _cell(result.question), ""]
        lines += [*(f"- {_cell(note)}" for note in result.notes), *[""] * bool(result.notes)]
        for item in boards(result):
            lines += [f"{item.table}, {_cell(item.condition)}, {_cell(item.group)}:", "", *_board_lines(item), ""]
    return "\n".join(lines)


def _board_lines(item: Board) -> list[str]:
    heads = [*map(metric_title, item.metrics), *(["time for an image"] if item.is_timed else [])]
    lines = [f"| rank | estimator | n | {' | '.join(heads)} | interval over |"]
    lines.append("|" + "---|" * (len(heads) + 4))
    for place in item.places:
        first = place.cells.get(item.metric) or next(iter(place.cells.values()))
        cells = [cell_text(place.cells.get(metric), first) for metric in item.metrics]
        if item.is_timed:
            cells.append("-" if place.seconds is None else seconds_text(place.seconds))
        name = f"**{_cell(place.name)}**" if place.leads else _cell(place.name)
        lines.append(f"| {place.rank or place.kind} | {name} | {first.n} | {' | '.join(cells)} | {first.over} |")
    return lines


def _cell(text: str) -> str:
    """Return a text that stays in its cell and marks nothing up."""
    for sign in "\\`*_|<[":
        text = text.replace(sign, f"\\{sign}")
    return " ".join(text.split())


_AS = "as "


def title_of(result: SuiteResult) -> str:
    """Return the suite with its size."""
    return f"{result.suite} (quick)" if result.quick else result.suite


def suite_section(result: SuiteResult, found: Sequence[Board], alone: bool) -> dict[str, Any]:
    """Show a suite: leaderboards, charts, confusions, and what it was made of.

    Args:
        result: Of the suite.
        found: Its leaderboards.
        alone: Whether nothing else is on the page; else charts of other metrics and groups are only counted.
    """
    looks = looks_of(result.estimators)
    found_panels = list(panels(result))
    return {
        "title": title_of(result),
        "question": result.question,
        "size": list(size_lines(result)),
        "command": result.command,
        "boards": [_board(item, looks) for item in found],
        "key": _key(result, looks) if found_panels else [],
        "charts": [(panel.title, panel.plot()) for panel in found_panels if panel.first],
        "more": [(panel.title, panel.plot()) for panel in found_panels if alone and not panel.first],
        "folded": 0 if alone else sum(not panel.first for panel in found_panels),
        "confusions": _confusions(result),
        "left_out": result.left_out,
        "notes": result.notes,
        "facts": _facts(result),
    }


def shown_cell(row: Row) -> dict[str, Any]:
    """Return what a cell shows of a fraction: text, interval and the numbers of its bar."""
    low, high = row.interval
    return {
        "text": percent(row.value),
        "interval": f"{100 * low:.0f}–{100 * high:.0f}",
        "value": 100.0 * row.value,
        "low": 100.0 * low,
        "high": 100.0 * high,
        "n": row.n,
    }


def _board(item: Board, looks: dict[str, Look]) -> dict[str, Any]:
    named = [TITLES[item.table], item.condition, *([] if item.group == "all" else [item.group])]
    return {
        "title": ", ".join(named),
        "how": HOW[item.table],
        "columns": [(metric_title(metric), help_of(metric)) for metric in item.metrics],
        "is_timed": item.is_timed,
        "seconds_help": help_of(SECONDS),
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
        "seconds": None if place.seconds is None else f"{place.seconds.value:.3g}",
        "machine": "" if place.seconds is None else place.seconds.machine,
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
        "Seconds": f"{result.seconds:g}; {result.reused} scores of a run before were used again",
        "Machine": json.dumps(result.machine, ensure_ascii=False),
        "Weights": ", ".join(f"{name} {digest}" for name, digest in weights.items()) or "none",
    }
