"""The log of all evaluations on a frozen set, which lies beside the sealed file: many of them are tuning, too."""

import csv
import io
from datetime import UTC, datetime
from pathlib import Path

from warehouse_sim.benchmark.result import SuiteResult
from warehouse_sim.benchmark.rows.row import HEADLINE, WORST
from warehouse_sim.output import write_bytes
from warehouse_sim.version import __version__

ENDING = ".evaluations.csv"
COLUMNS = ("date", "version", "suite", "estimator", "weights", "metric", "value", "low", "high", "n", "layout")
"""Of the log; the score is that of the layout in which the estimator docks least, empty if it was not scored in all."""


def log_evaluations(sealed: Path, result: SuiteResult) -> Path:
    """Add a line for each estimator of a result, and return the log.

    Args:
        sealed: The sealed file.
        result: What was found on it.
    """
    path = sealed.with_name(sealed.name + ENDING)
    text = io.StringIO(newline="")
    table = csv.writer(text, lineterminator="\n")
    if not path.is_file():
        table.writerow(COLUMNS)
    date, suite = datetime.now(UTC).date().isoformat(), result.suite + (", quick" if result.quick else "")
    for item in result.estimators:
        table.writerow([date, __version__, suite, item.name, item.weights_sha256, HEADLINE, *_worst(result, item.name)])
    write_bytes(path, (path.read_bytes() if path.is_file() else b"") + text.getvalue().encode("utf-8"), durable=True)
    return path


def _worst(result: SuiteResult, estimator: str) -> list[str]:
    """Return value, interval, number and name of the worst layout."""
    mine = [
        row
        for row in result.rows
        if (row.table, row.estimator, row.group, row.metric) == ("scores", estimator, "all", HEADLINE)
    ]
    worst = next((row for row in mine if row.condition == WORST), None)
    if worst is None:
        return [""] * 5
    layout = min((row for row in mine if row.condition != WORST), key=lambda row: row.value).condition
    return [f"{worst.value:.4f}", f"{worst.interval[0]:.4f}", f"{worst.interval[1]:.4f}", str(worst.n), layout]
