"""``warehouse-sim report``: one page that a person can look at."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish
from warehouse_sim.optional import require_extra


def report(folders: tyro.conf.Positional[tuple[Path, ...]], out: Path = Path("report.html")) -> None:
    """Write one self-contained HTML page about datasets, runs and scores.

    Args:
        folders: Dataset, run and evaluation folders.
        out: HTML file to write.
    """
    require_extra("report", "to write a report")
    from warehouse_sim.evaluation.report import write_report

    finish(write_report(folders, out))
