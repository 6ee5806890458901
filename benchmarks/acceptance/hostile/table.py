"""The result of a run: a table by kind of file and command, every failing case, and the JSON of both."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import Any

from rich.table import Table

from benchmarks.acceptance.hostile.judge import CLASSES, FAULTS
from benchmarks.acceptance.hostile.run import Result

_COMMAND = "python -m benchmarks.acceptance.hostile"


def count_table(results: Sequence[Result]) -> Table:
    """Return the counts of each class by kind of file and command."""
    table = Table(title=f"{len(results)} hostile cases")
    table.add_column("file")
    table.add_column("command")
    for name in CLASSES:
        table.add_column(name, justify="right")
    counts = _counts(results)
    for kind, command in sorted(counts):
        table.add_row(kind, command, *(str(counts[kind, command][name] or "") for name in CLASSES))
    total = Counter(result.verdict.label for result in results)
    table.add_section()
    table.add_row("all", "", *(str(total[name]) for name in CLASSES), style="bold")
    return table


def fault_lines(results: Sequence[Result]) -> list[str]:
    """Return each failing case, grouped by cause, the most frequent cause first."""
    by_cause: dict[tuple[str, str], list[Result]] = defaultdict(list)
    for result in results:
        if result.verdict.is_fault:
            by_cause[result.verdict.label, result.verdict.cause].append(result)
    lines = []
    for (label, cause), alike in sorted(by_cause.items(), key=lambda item: -len(item[1])):
        lines.append(f"{label}: {cause} ({len(alike)})")
        lines += [f"    {result.case.id}\n        {result.verdict.reason}" for result in alike]
    return lines


def as_json(
    results: Sequence[Result], seed: int, cases: int, machine: dict[str, Any], seconds: float
) -> dict[str, Any]:
    """Return the result as it is stored: a row for each kind of file and command, and every failing case."""
    counts, total = _counts(results), Counter(result.verdict.label for result in results)
    rows: list[dict[str, Any]] = [{"name": "all", "value": sum(total[name] for name in FAULTS), **_named(total)}]
    for kind, command in sorted(counts):
        faults = sum(counts[kind, command][name] for name in FAULTS)
        rows.append({"name": f"{kind}, {command}", "value": faults, **_named(counts[kind, command])})
    return {
        "machine": machine,
        "command": f"{_COMMAND} --cases {cases} --seed {seed}",
        "what": "hostile cases by kind of file and command; value: tracebacks, crashes, hangs and silent nonsense",
        "cases": len(results),
        "seconds": round(seconds),
        "rows": rows,
        "faults": [
            {
                "case": result.case.id,
                "class": result.verdict.label,
                "reason": result.verdict.reason,
                "replay": f"{_COMMAND} --only '{result.case.id}'",
            }
            for result in results
            if result.verdict.is_fault
        ],
    }


def _counts(results: Sequence[Result]) -> dict[tuple[str, str], Counter[str]]:
    counts: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for result in results:
        counts[result.case.kind, result.case.command][result.verdict.label] += 1
    return counts


def _named(counts: Counter[str]) -> dict[str, int]:
    return {name.replace(" ", "_"): counts[name] for name in CLASSES}
