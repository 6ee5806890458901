"""Put the sections into the template and write one self-contained page."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.report import charts
from warehouse_sim.evaluation.report.score_sections import evaluation_section, score_row
from warehouse_sim.evaluation.report.sections import dataset_section, run_section
from warehouse_sim.evaluation.report.sources import EvaluationSource, read_sources
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, write_bytes

_MANY = 3
"""From more evaluations than this on, each shows one case a group, to keep the page small."""


def write_report(folders: Sequence[str | Path], out: str | Path) -> Path:
    """Write one HTML page about dataset, run and evaluation folders; it needs no other file and no network.

    Args:
        folders: The folders, or folders that hold them; an evaluation needs its dataset among them.
        out: The page to write.

    Returns:
        ``out``.

    Raises:
        EvaluationError: No folder is named, one holds nothing to report, or an evaluation's dataset was not given.
        MissingPackageError: matplotlib or jinja2 is not installed.
    """
    if not folders:
        raise EvaluationError("there is nothing to report: name at least one dataset, run or evaluation folder")
    out = Path(out)
    sources = read_sources([Path(folder) for folder in folders])
    labels = _labels(sources.evaluations)
    named = list(zip(sources.evaluations, labels, strict=True))
    case_count = 3 if len(named) <= _MANY else 1
    html = render(
        scores=[score_row(source, label) for source, label in named],
        comparison=_comparison(named),
        evaluations=[evaluation_section(source, label, case_count) for source, label in named],
        runs=[run_section(run) for run in sources.runs],
        datasets=[dataset_section(data) for data in sources.datasets.values()],
    )
    make_folder(out.parent)
    write_bytes(out, html.encode("utf-8"))
    return out


def _labels(evaluations: Sequence[EvaluationSource]) -> list[str]:
    """Name each evaluation by its method; where methods repeat, by as much of the folders as tells them apart."""
    methods = [source.scores.method for source in evaluations]
    if len(set(methods)) == len(methods):
        return methods
    parts = [source.folder.parts for source in evaluations]
    length = next(n for n in range(1, max(map(len, parts)) + 1) if len({part[-n:] for part in parts}) == len(parts))
    return [f"{method} ({'/'.join(part[-length:])})" for method, part in zip(methods, parts, strict=True)]


def _comparison(named: Sequence[tuple[EvaluationSource, str]]) -> list[tuple[str, str]]:
    if not named:
        return []
    tables = {label: source.scores.table for source, label in named}
    marks = sorted({k for source, _ in named for k in source.scores.settings["metrics"]["diameter_percent"]})
    drawings = [("Accuracy over threshold", charts.accuracy_chart(tables, marks))]
    dockable = {label: table for label, table in tables.items() if table.dockable.any()}
    if dockable:
        drawings.append(("Docking over the clearance to spare", charts.docking_chart(dockable)))
    return drawings


def render(**context: Any) -> str:
    """Return the page of some sections: scores, comparison, evaluations, runs, datasets."""
    return filled(__package__, "page.html.j2", **context)


_LOOK = "warehouse_sim.evaluation.report"


def filled(package: str, name: str, **context: Any) -> str:
    """Return a page; whatever it is filled with is escaped.

    Args:
        package: Package that the template lies in.
        name: File name of the template; it may include ``look.css.j2``.
        **context: What the template shows.

    Raises:
        MissingPackageError: jinja2 is not installed.
    """
    jinja2 = require("jinja2", "report", "to write a report")
    loader = jinja2.ChoiceLoader([jinja2.PackageLoader(place, "") for place in dict.fromkeys((package, _LOOK))])
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name).render(**context)
