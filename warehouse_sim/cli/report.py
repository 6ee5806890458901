"""``warehouse-sim report``: one page that a person can look at."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish
from warehouse_sim.cli.replacing import write_one


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
    from warehouse_sim.api.scoring import report as write

    finish(write_one(out, lambda page: write(*folders, out=page), overwrite))
