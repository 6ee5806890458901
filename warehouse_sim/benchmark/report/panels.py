"""Which charts a result has: every table that a chart says more of than its numbers do."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

from warehouse_sim.benchmark.report.board import shorter
from warehouse_sim.benchmark.report.charts import (
    Axis,
    Looks,
    Plot,
    forest_chart,
    lines_chart,
    spread_chart,
)
from warehouse_sim.benchmark.report.looks import family_of, headline, looks_of, metric_title, shortened
from warehouse_sim.benchmark.result import SuiteResult
from warehouse_sim.benchmark.rows.row import Row, Table

_BIN = re.compile(r"(\d+(?:\.\d+)?)-\d+(?:\.\d+)? (m|visible)")
_BIN_TITLES = {"m": "distance (m)", "visible": "visible fraction"}
_GROUPS_FIRST = 3
"""Of how many groups or conditions curves and spreads are shown at once; those of the others can be opened."""
_MARKS_FIRST = 120
"""With more marks than this a chart is long, and shown when requested."""


@dataclass(frozen=True)
class Panel:
    """A chart of a page."""

    title: str
    plot: Plot
    first: bool
    """Shown at once; the others when requested."""


def panels(result: SuiteResult) -> Iterator[Panel]:
    """Yield the charts of a result; what has no rows has none."""
    looks, left_out = looks_of(result.estimators), shorter(result)
    rows = [row for row in result.rows if row.estimator not in left_out]
    scores = _of(rows, "scores")
    yield from _over_samples(result, looks)
    yield from _over_bins(scores, looks)
    yield from _over_margins(scores, looks)
    yield from _by_condition(scores, looks)
    yield from _by_category(scores, looks)
    yield from _effects(rows, looks)
    yield from _curves(rows, looks)
    yield from _spreads(rows, looks)
    yield from _precision(rows, looks)


def _of(rows: Sequence[Row], table: Table) -> list[Row]:
    return [row for row in rows if row.table == table]


def _lines(
    title: str, points: Sequence[tuple[Row, float]], looks: Looks, axis: Axis, first: bool = True
) -> Iterator[Panel]:
    """Yield a chart of lines, unless only the ground truth and chance are in it."""
    series: dict[str, list[tuple[float, Row]]] = {}
    for row, place in points:
        series.setdefault(row.estimator, []).append((place, row))
    if not all(looks[name].is_bound for name in series):
        yield Panel(title, partial(lines_chart, series, looks, axis), first)


def _without_bounds(rows: Sequence[Row], looks: Looks) -> list[Row]:
    """Leave out the ground truth and chance, which charts of levels do not need."""
    return [row for row in rows if not looks[row.estimator].is_bound]


def _places(rows: Sequence[Row]) -> Iterator[tuple[str, list[Row]]]:
    """Yield the rows of each condition with what a title says of it: nothing where there is one alone."""
    names = list(dict.fromkeys(row.condition for row in rows))
    for name in names:
        yield f", {name}" if len(names) > 1 else "", [row for row in rows if row.condition == name]


def _metrics(rows: Sequence[Row]) -> Iterator[tuple[str, list[Row], bool]]:
    """Yield the rows of each metric, the headline first, and whether it is that."""
    first = headline(rows)
    for metric in dict.fromkeys([first, *(row.metric for row in rows)] if rows else []):
        yield metric, [row for row in rows if row.metric == metric], metric == first


def _over_samples(result: SuiteResult, looks: Looks) -> Iterator[Panel]:
    """Score against training samples seen, a line for each that the suite trained; the others are level lines."""
    facts = {item.name: item for item in result.estimators}
    seen = [item.samples for item in result.estimators if item.samples is not None]
    rows = [row for row in _of(result.rows, "scores") if row.group == "all"] if len(set(seen)) > 1 else []
    heads: dict[str, str] = {}
    for item in result.estimators:
        heads.setdefault(family_of(item), item.name)
    for where, of_place in _places(rows):
        for metric, mine, first in _metrics(of_place):
            series: dict[str, list[tuple[float, Row]]] = {}
            for row in mine:
                samples = facts[row.estimator].samples
                ends = (min(seen), max(seen)) if samples is None else (samples,)
                head = heads[family_of(facts[row.estimator])]
                series.setdefault(head, []).extend((end / 1000.0, row) for end in ends)
            yield Panel(
                f"{metric_title(metric)} over samples seen{where}",
                partial(lines_chart, series, looks, Axis("training samples (thousands)")),
                first,
            )


def _over_bins(scores: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    """Score over distance or visible fraction, a chart for what else a group is of."""
    for where, of_place in _places(scores):
        kinds: dict[tuple[str, str], list[tuple[str, Row]]] = {}
        for row in of_place:
            parts = row.group.split(", ")
            bins = [part for part in parts if _BIN.fullmatch(part)]
            if len(bins) == 1:
                others = ", ".join(part for part in parts if part not in bins)
                kinds.setdefault((bins[0].rpartition(" ")[2], others), []).append((bins[0], row))
        for (unit, others), labelled in kinds.items():
            labels = sorted({label for label, _ in labelled}, key=lambda label: float(label.partition("-")[0]))
            place_of = {id(row): labels.index(label) for label, row in labelled}
            by = f"by {'distance' if unit == 'm' else 'visible fraction'}{where}{f', {others}' if others else ''}"
            for metric, mine, first in _metrics([row for _, row in labelled]):
                points = [(row, place_of[id(row)]) for row in mine]
                counted = {place: max(row.n for row, at in points if at == place) for _, place in points}
                ticks: dict[float, str] = {
                    k: f"{labels[k].rpartition(' ')[0]}\n({n})" for k, n in sorted(counted.items())
                }
                axis = Axis(f"{_BIN_TITLES[unit]}, of how many objects in brackets", ticks)
                yield from _lines(f"{metric_title(metric)} {by}", points, looks, axis, first)


def _over_margins(scores: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    """Fraction that docks over the clearance that must be left, in the true pockets and in the nominal ones."""
    places = list(_places([row for row in scores if row.group == "all"]))
    for where, of_place in places:
        for kind, title in (("dock", "Docked"), ("dock_nominal", "Docked, nominal pockets")):
            found = [(re.fullmatch(rf"{kind}_(\d+)mm", row.metric), row) for row in of_place]
            margins = sorted({int(named[1]) for named, _ in found if named})
            axis = Axis("clearance that must be left (mm)", {k: str(mm) for k, mm in enumerate(margins)}, "docked (%)")
            points = [(row, margins.index(int(named[1]))) for named, row in found if named]
            first = kind == "dock" and len(places) <= _GROUPS_FIRST
            if len(margins) > 1:
                yield from _lines(f"{title} over the clearance to spare{where}", points, looks, axis, first)


def _by_condition(scores: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    rows = _without_bounds([row for row in scores if row.group == "all"], looks)
    if len({row.condition for row in rows}) > 1:
        yield from _levels(rows, looks, "by condition", lambda row: row.condition)


def _by_category(scores: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    """Score by what is no scale: class, object, paired variant."""
    rows = [
        row
        for row in _without_bounds(scores, looks)
        if row.group != "all" and not any(_BIN.fullmatch(part) for part in row.group.split(", "))
    ]
    for where, of_place in _places(rows):
        if len({row.group for row in of_place}) > 1:
            yield from _levels(of_place, looks, f"by group{where}", lambda row: row.group)


def _levels(
    rows: Sequence[Row], looks: Looks, by: str, level_of: Callable[[Row], str], effect: bool = False
) -> Iterator[Panel]:
    for metric, mine, first in _metrics(rows):
        levels: dict[str, list[Row]] = {}
        for row in mine:
            levels.setdefault(level_of(row), []).append(row)
        label = f"{metric_title(metric)} ({'points' if effect else '%'})"
        yield Panel(
            f"{metric_title(metric)} {by}",
            partial(forest_chart, levels, looks, label, effect),
            first and len(mine) <= _MARKS_FIRST,
        )


def _effects(rows: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    """Paired effects, a chart for each factor and what it is held against."""
    kinds: dict[tuple[str, str], list[Row]] = {}
    for row in _without_bounds(_of(rows, "effects"), looks):
        kinds.setdefault((_factor(row)[0], row.against), []).append(row)
    for (factor, against), mine in kinds.items():
        several = len({(row.estimator, row.group) for row in mine}) < len(
            {(row.estimator, row.group, row.condition) for row in mine}
        )

        def level(row: Row, several: bool = several) -> str:
            parts = [_factor(row)[1], row.condition if several else ""]
            return ", ".join(part for part in parts if part) or "all"

        names = {row.estimator for row in mine}
        who = f"{shortened(next(iter(names)))} " if len(names) == 1 else ""
        levels = {level(row) for row in mine} - {"all"}
        what = f"{factor}: {next(iter(levels))}" if len(levels) == 1 else factor
        by = f"gained or lost by {what}, {who}against {shortened(against)}"
        yield from _levels(mine, looks, by, level, effect=True)


def _factor(row: Row) -> tuple[str, str]:
    """Split the label of an effect into the factor and its level."""
    sign = ": " if ": " in row.group else ", "
    factor, _, level = row.group.partition(sign)
    return factor, level


def _curves(rows: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    axis = Axis("ADD below this part of the diameter (%)")
    yield from _numbered(_of(rows, "curves"), looks, r"add_(\d+)pct", "Accuracy over threshold", axis)


def _precision(rows: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    axis = Axis("recall (%)", unit="precision (%)")
    yield from _numbered(_of(rows, "precision"), looks, r"at_recall_(\d+)", "Precision by recall", axis)


def _numbered(rows: Sequence[Row], looks: Looks, pattern: str, title: str, axis: Axis) -> Iterator[Panel]:
    """Yield a chart for each group, over the number in the names of the metrics."""
    for where, of_place in _places(rows):
        for number, group in enumerate(dict.fromkeys(row.group for row in of_place)):
            found = [(re.fullmatch(pattern, row.metric), row) for row in of_place if row.group == group]
            points = [(row, float(named[1])) for named, row in found if named]
            yield from _lines(f"{title}, {group}{where}", points, looks, axis, number < _GROUPS_FIRST)


def _spreads(rows: Sequence[Row], looks: Looks) -> Iterator[Panel]:
    for where, of_place in _places(_of(rows, "spread")):
        for number, group in enumerate(dict.fromkeys(row.group for row in of_place)):
            mine = [row for row in of_place if row.group == group]
            yield Panel(
                f"How the error is spread, {group}{where}",
                partial(spread_chart, mine, looks),
                number < _GROUPS_FIRST,
            )
