"""Put suites on one page that needs no other file and no network; or their leaderboards into Markdown."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.report.across import first_boards, standings
from warehouse_sim.benchmark.report.board import Board, boards
from warehouse_sim.benchmark.report.markdown import cell_text
from warehouse_sim.benchmark.report.names import metric_title
from warehouse_sim.benchmark.report.sections import shown_cell, suite_section, title_of
from warehouse_sim.benchmark.result import SuiteResult, read_result
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.errors import DatasetError, EvaluationError
from warehouse_sim.evaluation.report.template import filled
from warehouse_sim.output import make_folder, write_bytes

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
        MissingPackageError: matplotlib or jinja2 is not installed.
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
        suites=[
            suite_section(result, boards_of[title], number, len(results) == 1)
            for number, (title, result) in enumerate(results.items())
        ],
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
        "heads": [(suite, metric_title(board.metric), board.condition) for suite, board in found.items()],
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
        for item in boards(result):
            lines += [f"{item.table}, {_cell(item.condition)}, {_cell(item.group)}:", "", *_board_lines(item), ""]
    return "\n".join(lines)


def _board_lines(item: Board) -> list[str]:
    lines = [f"| rank | estimator | n | {' | '.join(map(metric_title, item.metrics))} | interval over |"]
    lines.append("|" + "---|" * (len(item.metrics) + 4))
    for place in item.places:
        first = place.cells.get(item.metric) or next(iter(place.cells.values()))
        cells = [cell_text(place.cells.get(metric), first) for metric in item.metrics]
        name = f"**{_cell(place.name)}**" if place.leads else _cell(place.name)
        lines.append(f"| {place.rank or place.kind} | {name} | {first.n} | {' | '.join(cells)} | {first.over} |")
    return lines


def _cell(text: str) -> str:
    """Return a text that stays in its cell and marks nothing up."""
    for sign in "\\`*_|<[":
        text = text.replace(sign, f"\\{sign}")
    return " ".join(text.split())
