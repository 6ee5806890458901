"""A result as a Markdown page, with an interval in every cell."""

from collections.abc import Iterator, Mapping, Sequence

from warehouse_sim.benchmark.result import SuiteResult
from warehouse_sim.benchmark.rows.row import HEADLINE, WORST, Row, Table
from warehouse_sim.evaluation.report.numbers import percent

TITLES: dict[Table, str] = {
    "scores": "Scores",
    "effects": "Paired effects",
    "curves": "Accuracy over threshold",
    "spread": "Spread of the error, in per cent of the diameter",
    "detection": "Detection",
    "confusion": "Confusion",
    "precision": "Precision by recall",
    "faces": "Recorded faces",
    "simulated": "Simulated truck",
    "driven": "Closed loop",
    "negatives": "Negatives",
    "time": "Run time",
}
HOW: dict[Table, str] = {
    "scores": "Per cent of the ground truths that count; a miss is a failure. 95 % intervals in brackets.",
    "effects": "Points gained (+) or lost (-) on the same ground truths with one thing changed, 95 % intervals in "
    "brackets; bold where the interval excludes zero.",
    "curves": "Per cent with an ADD below that fraction of the diameter.",
    "spread": "Quantiles of ADD; a miss counts as a whole diameter.",
    "detection": "Average precision in per cent, intervals over scenes.",
    "confusion": "Per cent of the true objects of a class that were detected as another class, or missed.",
    "precision": "Precision in per cent at recalls of 10 to 100 %.",
    "faces": "Per cent of recorded faces that a fork with this estimate enters.",
    "simulated": "Per cent of the poses at which a simulated truck takes the pallet.",
    "driven": "Per cent of the approaches with the estimator in the loop that dock, and that stop by themselves.",
    "negatives": "Per cent of pallets that are accepted, and of negatives that are rejected, at the score that accepts "
    "95 of 100 pallets.",
    "time": "Mean seconds for an image, detection included; 95 % intervals in brackets, on the machine beside them.",
}
_REASONS = 3
"""Reasons why docking is not evaluated that are named for each dataset."""


def page(result: SuiteResult) -> str:
    """Return the page of a result."""
    lines = [f"# {result.suite}{' (quick)' if result.quick else ''}", "", result.question, "", *size_lines(result), ""]
    if any(row.condition == WORST for row in result.rows):
        lines += ["## Docked by layout, the worst first", "", *_by_layout(result.rows), ""]
    for table, title in TITLES.items():
        rows = [row for row in result.rows if row.table == table]
        if rows:
            lines += [f"## {title}", "", HOW[table], "", *_table(rows), ""]
    if result.left_out:
        lines += ["## Not scored", ""]
        lines += [f"- {item.estimator}, {item.condition}: {item.reason}" for item in result.left_out]
        lines.append("")
    if result.notes:
        lines += ["## Notes", "", *(f"- {note}" for note in result.notes), ""]
    return "\n".join(lines)


def summary(result: SuiteResult) -> Iterator[str]:
    """Yield the most important lines."""
    yield from size_lines(result)
    for table in ("scores", "effects", "detection", "faces", "negatives"):
        rows = [row for row in result.rows if row.table == table]
        if table == "scores":
            rows = [row for row in rows if row.group == "all"] or rows
        if rows:
            yield from face_lines(rows) if table == "faces" else _table(rows)
    for item in result.left_out:
        yield f"not scored: {item.estimator}, {item.condition}: {item.reason}"
    for note in result.notes:
        yield f"note: {note}"


def face_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line for each method and condition of recorded faces: into how many of them a fork goes."""
    several = len({row.group for row in rows}) > 1
    for row in rows:
        where = f", {row.group}" if several else ""
        yield f"{row.estimator}, {row.condition}{where}  {round(row.value * row.n)} of {row.n}"


def size_lines(result: SuiteResult) -> Iterator[str]:
    """Yield the size of each dataset of a result."""
    if result.quick:
        yield "Run at the small sizes of --quick: rely on the intervals, not on the numbers."
    for item in result.data:
        source = f"recipe {item.recipe} {item.recipe_sha256}, seed {item.seed}" if item.recipe else item.recipe_sha256
        left = _reasons(item.left_out_of_docking)
        yield (
            f"{item.name}: {_counted(item.scenes, 'scene')}, {_counted(item.images, 'image')}, "
            f"{_counted(item.ground_truths, 'ground truth')} ({source})"
            f"{'; docking is not evaluated for: ' + left if left else ''}"
        )


def _reasons(left_out: Mapping[str, int]) -> str:
    """Return the most frequent reasons and how many have another; the result file has all."""
    ordered = sorted(left_out.items(), key=lambda item: -item[1])
    shown = [f"{count} {why}" for why, count in ordered[:_REASONS]]
    others = sum(count for _, count in ordered[_REASONS:])
    return ", ".join([*shown, *([f"{others} for other reasons"] if others else [])])


def _counted(count: int, thing: str) -> str:
    return f"{count} {thing}{'' if count == 1 else 's'}"


def _table(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a table with a line for each estimator, condition and group, and a column for each metric."""
    metrics = list(dict.fromkeys(row.metric for row in rows))
    lines: dict[tuple[str, ...], dict[str, Row]] = {}
    for row in rows:
        lines.setdefault((row.estimator, row.condition, row.group, row.against), {})[row.metric] = row
    paired = any(row.against for row in rows)
    head = ["estimator", "condition", "group", *(["against"] if paired else []), "n", *metrics, "interval over"]
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    for (estimator, condition, group, against), cells in lines.items():
        first = max(cells.values(), key=lambda row: row.n)
        shown = [cell_text(cells.get(metric), first) for metric in metrics]
        named = [estimator, condition, group, *([against] if paired else []), str(first.n)]
        yield f"| {' | '.join([*named, *shown, first.over])} |"


def _by_layout(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a table with a line for each layout, that where estimators dock least first, and a column for each."""
    docked = [row for row in rows if (row.table, row.group, row.metric) == ("scores", "all", HEADLINE)]
    layouts: dict[str, dict[str, Row]] = {}
    for row in docked:
        if row.condition != WORST:
            layouts.setdefault(row.condition, {})[row.estimator] = row
    names = list(dict.fromkeys(row.estimator for row in docked))
    yield f"| layout | n | {' | '.join(names)} |"
    yield "|" + "---|" * (len(names) + 2)
    for layout, cells in sorted(layouts.items(), key=lambda item: _mean(item[1])):
        first = max(cells.values(), key=lambda row: row.n)
        yield f"| {layout} | {first.n} | {' | '.join(cell_text(cells.get(name), first) for name in names)} |"


def _mean(cells: Mapping[str, Row]) -> float:
    return sum(row.value for row in cells.values()) / len(cells)


def cell_text(row: Row | None, first: Row) -> str:
    """Return a number with its interval, and on how many it was counted where that differs from the first."""
    if row is None:
        return "-"
    low, high = row.interval
    if row.table == "time":
        text = seconds_text(row)
    elif row.table != "effects":
        text = f"{percent(row.value)} [{100 * low:.0f}, {100 * high:.0f}]"
    else:
        text = f"{100 * row.value:+.1f} [{100 * low:+.1f}, {100 * high:+.1f}]"
        text = f"**{text}**" if low > 0.0 or high < 0.0 else text
    return text if row.n == first.n else f"{text} of {row.n}"


def seconds_text(row: Row) -> str:
    """Return a time with its interval and the machine that it was measured on."""
    low, high = row.interval
    return f"{row.value:.3g} s [{low:.3g}, {high:.3g}] on {row.machine or 'a machine that nobody stated'}"
