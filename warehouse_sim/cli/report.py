"""``warehouse-sim report``: one page that a person can look at."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish, require_ending
from warehouse_sim.cli.replacing import write_one
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra


def report(
    folders: tyro.conf.Positional[tuple[Path, ...]], out: Path = Path("report.html"), overwrite: bool = False
) -> None:
    """Write one self-contained HTML page about datasets, runs and scores, or about suites of the benchmark.

    Args:
        folders: Dataset, run and evaluation folders; or results of suites (SUITE.json) and folders of them, of which
            charts and leaderboards are drawn.
        out: HTML file to write; of suites, a name that ends in .md takes the leaderboards alone, as Markdown.
        overwrite: Replace the file where it has other content.
    """
    require_extra("report", "to write a report")
    from warehouse_sim.benchmark.report import is_results, write_suite_report
    from warehouse_sim.evaluation.report import write_report

    suites = [is_results(path) for path in folders]
    if any(suites) and not all(suites):
        other = folders[suites.index(False)]
        raise InputError(
            f"{other}: holds no results of suites, as others of the paths do; give those to a page of their own"
        )
    require_ending("--out", out, *((".html", ".htm", ".md") if any(suites) else (".html", ".htm")))
    write = write_suite_report if any(suites) else write_report
    finish(write_one(out, lambda page: write(folders, page), overwrite))
