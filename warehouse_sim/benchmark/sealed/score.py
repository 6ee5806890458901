"""Score predictions on a frozen set and log it: aggregates go out, nothing of a single image does."""

import csv
import io
from datetime import UTC, datetime
from pathlib import Path

from warehouse_sim.benchmark.entrants.entrant import Group, ResultFile
from warehouse_sim.benchmark.machine import machine
from warehouse_sim.benchmark.result import DataFacts, EstimatorFacts, SuiteResult
from warehouse_sim.benchmark.rows.row import HEADLINE, WORST, Row
from warehouse_sim.benchmark.rows.scores import score_rows, worst_rows
from warehouse_sim.benchmark.scored import SPLITS, Answer, Opened
from warehouse_sim.benchmark.sealed.seal import opened, read_facts, require_sealed, unsealed
from warehouse_sim.benchmark.sets import MadeSet
from warehouse_sim.benchmark.suite import Suite, load_suite
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError
from warehouse_sim.evaluation import evaluate
from warehouse_sim.output import write_bytes
from warehouse_sim.version import __version__


def open_set(suite: Suite, sealed: Path, public: Path | None, out: Path) -> tuple[dict[str, Opened], str]:
    """Return the datasets of a frozen set, both halves of each put together, and what to note of it.

    Args:
        suite: The suite that runs on it.
        sealed: The sealed file.
        public: The public folder.
        out: Folder of the benchmark.

    Raises:
        InputError: A half is missing, was changed, or is of another suite.
    """
    facts = read_facts(sealed)
    if public is None or not set(facts.data) <= set(suite.data):
        raise InputError(
            f"--sealed {sealed}: holds {facts.name} of the suite {facts.suite}; name its folder with --data"
        )
    roots = unsealed(sealed, public, out / "unsealed" / facts.name)
    opened_ones = {name: Opened(MadeSet(name, root), DatasetReader(root), {}) for name, root in roots.items()}
    return opened_ones, f"frozen set {facts.name}"


def evaluate_sealed(predictions: Path, sealed: Path, sums: Path | None = None) -> SuiteResult:
    """Return the scores of a method on a frozen set.

    Args:
        predictions: Folder with a BOP pose CSV for each dataset of the set, ``selective_rack.csv`` and so on; what one
            leaves out is missed.
        sealed: The sealed file.
        sums: List of hashes that it is checked by; the shipped one by default.

    Raises:
        InputError: The file is not the one whose hash is listed, or there is no CSV for a dataset.
        EvaluationError: A CSV does not fit its dataset.
    """
    require_sealed(sealed, sums)
    facts = read_facts(sealed)
    missing = [name for name in facts.data if not (predictions / f"{name}.csv").is_file()]
    if missing:
        raise InputError(f"{predictions}: lacks {', '.join(f'{name}.csv' for name in missing)}: one for each layout")
    suite, method = load_suite(facts.suite), predictions.resolve().name
    group = Group(method, (ResultFile(method, predictions),))
    rows, data = list[Row](), list[DataFacts]()
    with opened(sealed) as folder:
        for name in facts.data:
            reader = DatasetReader(folder / name)
            scores = evaluate(predictions / f"{name}.csv", reader, SPLITS[0], method)
            answer = Answer(group, name, Opened(MadeSet(name, reader.root), reader, {}), (scores,))
            rows += score_rows(answer, suite)
            images = reader.images(SPLITS[0])
            scenes = len({image.scene_id for image in images})
            left_out = dict(scores.docking_left_out)
            data.append(DataFacts(name, "", reader.digest[:16], None, scenes, len(images), len(scores.table), left_out))
    return SuiteResult(
        suite=suite.title,
        question=suite.question,
        quick=False,
        command=f"warehouse-sim evaluate {method} --sealed {sealed.name}",
        machine=machine(),
        seconds=0.0,
        reused=0,
        data=tuple(data),
        estimators=(EstimatorFacts(method, 0),),
        rows=(*(worst_rows(rows, list(facts.data)) if suite.worst_first else ()), *rows),
        notes=(f"frozen set {facts.name}",),
    )


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
