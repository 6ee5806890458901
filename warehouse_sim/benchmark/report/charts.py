"""The charts of a suite, each from rows of its result to an SVG element.

What is drawn of an estimator is named by its number among those of the result: ``points-3``, ``interval-3``; where each
row has an element of its own, the place of the row from above follows: ``points-3-0``.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from warehouse_sim.benchmark.report.looks import Look, shortened
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.evaluation.report.figure import chart

Looks = Mapping[str, Look]
Draw = Callable[[str], str]
"""Draws a chart with the names in it behind a prefix."""
_QUIET = "#8b949e"
_DODGE, _DODGED = 0.07, 0.4
"""How far lines of places stand apart, and all of them at most."""
_LEAST_PERCENT = 0.1
"""Where the axis of a spread begins; what lies below is drawn there."""
_QUANTILES = ("add_q05", "add_q25", "add_q50", "add_q75", "add_q95")


@dataclass(frozen=True)
class Axis:
    """What the horizontal axis of a chart of lines is."""

    label: str
    ticks: Mapping[float, str] = field(default_factory=dict)
    """Names of places, where it is no scale of numbers."""
    unit: str = "objects (%)"
    """What the vertical axis counts."""
    bands: bool = False
    """Draw intervals as bands in place of bars."""


def lines_chart(series: Mapping[str, Sequence[tuple[float, Row]]], looks: Looks, axis: Axis, prefix: str = "") -> str:
    """Draw shares over something, a line an estimator with its intervals; bounds are lines without."""
    with chart() as drawing:
        axes = drawing.axes
        shown = [name for name in looks if name in series and not looks[name].is_bound]
        apart = min(_DODGE, _DODGED / max(len(shown), 1))
        for name in (item for item in looks if item in series):
            look, points = looks[name], sorted(series[name], key=lambda point: point[0])
            shift = apart * (shown.index(name) - (len(shown) - 1) / 2) if axis.ticks and name in shown else 0.0
            _line(axes, look, points, shift, axis.bands)
        if axis.ticks:
            axes.set_xticks(list(axis.ticks), list(axis.ticks.values()))
            axes.set_xlim(min(axis.ticks) - 0.5, max(axis.ticks) + 0.5)
            if len(axis.ticks) > 5:
                axes.tick_params(axis="x", labelsize=8)
        else:
            axes.set_xlim(left=0)
        # Chance and the ground truth may lie outside; what is compared shall not be squeezed for them.
        least = min((100.0 * row.interval[0] for name in shown for _, row in series[name]), default=0.0)
        axes.set(ylim=(max(0.96 * least - 5.0, -1.5), 101.5), xlabel=axis.label, ylabel=axis.unit)
        return drawing.svg(prefix)


def _line(axes: Any, look: Look, points: Sequence[tuple[float, Row]], shift: float, band: bool) -> None:
    places = [x + shift for x, _ in points]
    values, low, high = _percent([row for _, row in points])
    style = {"color": look.color, "linestyle": look.dash, "marker": look.mark, "markersize": 4.5}
    width = 1.0 if look.kind else 1.6
    axes.plot(places, values, gid=f"points-{look.number}", linewidth=width, zorder=2 if look.kind else 3, **style)
    if look.is_bound:
        return
    if band:
        drawn = axes.fill_between(places, low, high, color=look.color, alpha=0.13, linewidth=0)
    else:
        drawn = axes.vlines(places, low, high, color=look.color, alpha=0.55, linewidth=1.4)
    drawn.set_gid(f"interval-{look.number}")


def forest_chart(levels: Mapping[str, Sequence[Row]], looks: Looks, label: str, effect: bool, prefix: str = "") -> str:
    """Draw values with intervals beside one another, a line each, by level; one level alone names the estimators.

    Marks of effects whose interval holds zero are hollow.

    Args:
        levels: Rows by what stands on the left, from above.
        looks: Of all estimators.
        label: Of the horizontal axis.
        effect: Whether values are differences.
        prefix: Of names in the chart.
    """
    alone = len(levels) == 1
    lines, ticks = _places(levels, looks)
    with chart(height=0.9 + 0.21 * max(len(lines), 4) + 0.09 * len(levels)) as drawing:
        axes = drawing.axes
        for number, (place, row) in enumerate(lines):
            look = looks[row.estimator]
            (value,), (low,), (high,) = _percent([row])
            clear = not effect or low > 0.0 or high < 0.0
            interval = axes.hlines([place], [low], [high], color=look.color, linewidth=1.6, alpha=0.6)
            interval.set_gid(f"interval-{look.number}-{number}")
            axes.plot(
                [value],
                [place],
                gid=f"points-{look.number}-{number}",
                color=look.color,
                marker=look.mark,
                markersize=5.5,
                linestyle="none",
                markerfacecolor=look.color if clear else "none",
                zorder=4,
            )
        if effect:
            axes.axvline(0.0, color=_QUIET, linewidth=1.0)
        names = [(place, looks[row.estimator].short) for place, row in lines] if alone else ticks
        axes.set_yticks([place for place, _ in names], [name for _, name in names])
        axes.grid(visible=False, axis="y")
        axes.set(xlabel=label, ylim=(min(place for place, _ in lines) - 0.7, 0.7))
        if not effect:
            axes.set_xlim(-1.5, 101.5)
        return drawing.svg(prefix)


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


def spread_chart(rows: Sequence[Row], looks: Looks, prefix: str = "") -> str:
    """Draw a box of the quarters of ADD an estimator, whiskers to 5 and 95 %, and below it the interval of the median.

    What lies below a thousandth of the diameter is drawn there.
    """
    found = {name: {row.metric: row for row in rows if row.estimator == name} for name in looks}
    shown = [look for name, look in looks.items() if set(_QUANTILES) <= set(found[name])]
    with chart(height=0.8 + 0.38 * len(shown)) as drawing:
        axes = drawing.axes
        for number, look in enumerate(shown):
            quantiles = [max(100.0 * found[look.name][name].value, _LEAST_PERCENT) for name in _QUANTILES]
            _box(axes, -float(number), quantiles, look)
            ends = [max(100.0 * end, _LEAST_PERCENT) for end in found[look.name]["add_q50"].interval]
            interval = axes.hlines([-number - 0.36], *([end] for end in ends), color=look.color, linewidth=1.6)
            interval.set_gid(f"interval-{look.number}")
        axes.set_yticks([-float(number) for number in range(len(shown))], [look.short for look in shown])
        axes.grid(visible=False, axis="y")
        axes.set(xscale="log", xlim=(_LEAST_PERCENT * 0.85, 115.0), ylim=(0.4 - len(shown), 0.5))
        axes.set_xticks([0.1, 1, 10, 100], ["≤ 0.1", "1", "10", "100"])
        axes.minorticks_off()
        axes.set_xlabel("ADD (% of the diameter)")
        return drawing.svg(prefix)


def _box(axes: Any, place: float, quantiles: Sequence[float], look: Look) -> None:
    """Draw a box of five quantiles; it is drawn by hand, since matplotlib would count them as samples."""
    least, low, middle, high, most = quantiles
    whisker = axes.hlines([place, place], [least, high], [low, most], color=look.color, linewidth=1.2)
    whisker.set_gid(f"whisker-{look.number}")
    # On a logarithmic axis a bar's left edge is where it begins, its width what it adds.
    bars = axes.barh([place], [high - low], left=[low], height=0.46, color=look.color, alpha=0.28, linewidth=0)
    bars.patches[0].set_gid(f"box-{look.number}")
    axes.plot(
        [middle],
        [place],
        gid=f"points-{look.number}",
        linestyle="none",
        marker="|",
        markersize=11,
        markeredgewidth=2.2,
        color=look.color,
    )


def _percent(rows: Sequence[Row]) -> tuple[list[float], list[float], list[float]]:
    columns = [100.0 * row.value for row in rows], *([100.0 * row.interval[k] for row in rows] for k in (0, 1))
    return columns[0], columns[1], columns[2]
