"""How numbers read on the page."""

import math
from typing import Any

from warehouse_sim.evaluation.summary import Summary

NOTHING = ""
"""What a cell without a number holds."""


def percent(value: float | None) -> str:
    """Write a fraction as a percentage; 100.0 is kept for what is really all."""
    if value is None or math.isnan(value):
        return NOTHING
    text = f"{100.0 * value:.1f}"
    return "99.9" if text == "100.0" and value < 1.0 else text


def centimetres(value: float | None) -> str:
    """Write a length (m) in cm."""
    return NOTHING if value is None or not math.isfinite(value) else f"{100.0 * value:.2f}"


def degrees(value: float | None) -> str:
    """Write an angle that is in degrees already."""
    return NOTHING if value is None or not math.isfinite(value) else f"{value:.2f}"


def signed(value: float) -> str:
    """Write a number with its sign and one decimal; what rounds to zero has none."""
    rounded = round(float(value), 1)
    return f"{rounded:+.1f}".replace("-", "−") if rounded else "0.0"


def counted(count: int, singular: str) -> str:
    """Write a count with its unit, in the plural where it is not one."""
    return f"{count:,} {singular}" if count == 1 else f"{count:,} {singular}s"


def fraction_cell(summary: Summary, name: str) -> dict[str, Any]:
    """Return what a table cell shows of a fraction: text, 95 % interval and the numbers for its bar."""
    value = summary.metrics.get(name, math.nan)
    if math.isnan(value):
        return {"text": NOTHING, "interval": "", "value": None}
    low, high = summary.intervals[name]
    return {
        "text": percent(value),
        "interval": f"{100.0 * low:.0f}–{100.0 * high:.0f}",
        "value": 100.0 * value,
        "low": 100.0 * low,
        "high": 100.0 * high,
    }
