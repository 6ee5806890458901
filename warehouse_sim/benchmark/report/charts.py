"""The charts of a suite, each from rows of its result to a figure."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from warehouse_sim.benchmark.report.looks import Look, shortened
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.dataset.viewing.page.template import Chart
from warehouse_sim.evaluation.report.figure import Trace, axis, dots, figure, line, rule, whiskers, words

Looks = Mapping[str, Look]
Plot = Callable[[], Chart]
_DODGE, _DODGED = 0.07, 0.4
"""How far lines of places stand apart, and all of them at most."""
_LEAST_PERCENT = 0.1
"""Where the axis of a spread begins; what lies below is plotted there."""
_QUANTILES = ("add_q05", "add_q25", "add_q50", "add_q75", "add_q95")
_ROW_PX, _FRAME_PX = 22, 110


@dataclass(frozen=True)
class Axis:
    """What the horizontal axis of a chart of lines is."""

    label: str
    ticks: Mapping[float, str] = field(default_factory=dict)
    """Names of places, where it is no scale of numbers."""
    unit: str = "objects (%)"
    """What the vertical axis counts."""


def lines_chart(series: Mapping[str, Sequence[tuple[float, Row]]], looks: Looks, given: Axis) -> Chart:
    """Plot shares over something, a line an estimator with its intervals; bounds are lines without."""
    shown = [name for name in looks if name in series and not looks[name].is_bound]
    apart = min(_DODGE, _DODGED / max(len(shown), 1))
    traces = []
    for name in (item for item in looks if item in series):
        points = sorted(series[name], key=lambda point: point[0])
        shift = apart * (shown.index(name) - (len(shown) - 1) / 2) if given.ticks and name in shown else 0.0
        traces.append(_line(looks[name], points, shift))
    x = axis(given.label, (min(given.ticks) - 0.5, max(given.ticks) + 0.5), given.ticks) if given.ticks else None
    # Chance and the ground truth may lie outside; what is compared shall not be squeezed for them.
    least = min((100.0 * row.interval[0] for name in shown for _, row in series[name]), default=0.0)
    y = axis(given.unit, (max(0.96 * least - 5.0, -1.5), 101.5))
    return figure(traces, x or axis(given.label) | {"rangemode": "tozero"}, y, showlegend=False)


def _line(look: Look, points: Sequence[tuple[float, Row]], shift: float) -> Trace:
    values, low, high = _percent([row for _, row in points])
    found = line([x + shift for x, _ in points], values, look.name, look.color, dash=look.dash, mode="lines+markers")
    found["marker"] = {"symbol": look.mark, "size": 7, "color": look.color}
    return found if look.is_bound else found | {"error_y": whiskers(values, low, high)}


def forest_chart(levels: Mapping[str, Sequence[Row]], looks: Looks, label: str, effect: bool) -> Chart:
    """Plot values with intervals beside one another, a line each, by level; one level alone names the estimators.

    Marks of effects whose interval holds zero are hollow.

    Args:
        levels: Rows by what stands on the left, from above.
        looks: Of all estimators.
        label: Of the horizontal axis.
        effect: Whether values are differences.
    """
    lines, ticks = _places(levels, looks)
    by_name: dict[str, list[tuple[float, Row]]] = {}
    for place, row in lines:
        by_name.setdefault(row.estimator, []).append((place, row))
    traces = []
    for name, placed in by_name.items():
        look, (values, low, high) = looks[name], _percent([row for _, row in placed])
        hollow = [effect and start <= 0.0 <= end for start, end in zip(low, high, strict=True)]
        symbols = [f"{look.mark}-open" if item else look.mark for item in hollow]
        found = dots(values, [place for place, _ in placed], name, look.color, symbol=symbols, size=9)
        traces.append(found | {"error_x": whiskers(values, low, high)})
    names = {place: looks[row.estimator].short for place, row in lines} if len(levels) == 1 else dict(ticks)
    return figure(
        traces,
        axis(label, None if effect else (-1.5, 101.5)),
        axis("", (min(place for place, _ in lines) - 0.7, 0.7), names) | {"showgrid": False},
        height=_FRAME_PX + _ROW_PX * max(len(lines), 4) + 9 * len(levels),
        shapes=[rule(0.0, "x")] if effect else [],
        showlegend=False,
    )


def _places(
    levels: Mapping[str, Sequence[Row]], looks: Looks
) -> tuple[list[tuple[float, Row]], list[tuple[float, str]]]:
    """Return where the line of each row lies, downwards from 0, and the middle of each level with its name."""
    lines: list[tuple[float, Row]] = []
    ticks: list[tuple[float, str]] = []
    top = 0.0
    order = list(looks)
    for level, rows in levels.items():
        for number, row in enumerate(sorted(rows, key=lambda row: order.index(row.estimator))):
            lines.append((top - number, row))
        ticks.append((top - (len(rows) - 1) / 2, shortened(level)))
        top -= len(rows) + 0.6
    return lines, ticks


def spread_chart(rows: Sequence[Row], looks: Looks) -> Chart:
    """Plot a box of the quarters of ADD an estimator, whiskers to 5 and 95 %, and below it the interval of the median.

    What lies below a thousandth of the diameter is plotted there.
    """
    found = {name: {row.metric: row for row in rows if row.estimator == name} for name in looks}
    shown = [look for name, look in looks.items() if set(_QUANTILES) <= set(found[name])]
    traces: list[Trace] = []
    for number, look in enumerate(shown):
        least, low, middle, high, most = ([_seen(found[look.name][name].value)] for name in _QUANTILES)
        whole = {"lowerfence": least, "q1": low, "median": middle, "q3": high, "upperfence": most}
        box = {"type": "box", "orientation": "h", "y": [-number], "name": words(look.name), "width": 0.46}
        traces.append(box | whole | {"marker": {"color": look.color}})
        ends = [_seen(end) for end in found[look.name]["add_q50"].interval]
        place = -number - 0.36
        traces.append(line(ends, [place, place], f"{look.name}: interval of the median", look.color, width=2))
    names = {-float(number): look.short for number, look in enumerate(shown)}
    ticks = {0.1: "≤ 0.1", 1.0: "1", 10.0: "10", 100.0: "100"}
    return figure(
        traces,
        axis("ADD (% of the diameter)", (-1.07, 2.06), ticks) | {"type": "log"},
        axis("", (0.4 - len(shown), 0.5), names) | {"showgrid": False},
        height=_FRAME_PX + 36 * len(shown),
        showlegend=False,
    )


def _seen(fraction: float) -> float:
    """Return a fraction of the diameter in per cent, as far as the axis shows it."""
    return max(100.0 * fraction, _LEAST_PERCENT)


def _percent(rows: Sequence[Row]) -> tuple[list[float], list[float], list[float]]:
    columns = [100.0 * row.value for row in rows], *([100.0 * row.interval[k] for row in rows] for k in (0, 1))
    return columns[0], columns[1], columns[2]
