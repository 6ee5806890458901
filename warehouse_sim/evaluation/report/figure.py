"""Figures as Plotly takes them: plain data, which the page plots in the colours of its scheme."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from warehouse_sim.dataset.viewing.page.template import Chart

PALETTE = ("#2f6fde", "#e07b1f", "#1d9a78", "#8a55d7", "#c2405a", "#6b7785")
QUIET = "#8b949e"
Trace = dict[str, Any]


def numbers(values: Sequence[float] | np.ndarray) -> list[float | None]:
    """Return numbers with four significant digits; what is not finite is a gap."""
    return [float(f"{value:.4g}") if np.isfinite(value) else None for value in np.asarray(values, float)]


def words(text: str) -> str:
    """Return a text that Plotly shows as it is: it knows some tags of HTML."""
    return escape(text, quote=False)


def line(x: Sequence[float] | np.ndarray, y: Sequence[float] | np.ndarray, name: str, color: str, **more: Any) -> Trace:
    """Return a line through points; ``dash`` and ``width`` are those of Plotly."""
    look = {"color": color} | {key: more.pop(key) for key in ("dash", "width") if key in more}
    return {
        "type": "scatter",
        "mode": "lines",
        "x": numbers(x),
        "y": numbers(y),
        "name": words(name),
        "line": look,
        **more,
    }


def dots(x: Sequence[float] | np.ndarray, y: Sequence[float] | np.ndarray, name: str, color: str, **more: Any) -> Trace:
    """Return points; ``symbol`` and ``size`` are those of Plotly."""
    look = {"color": color} | {key: more.pop(key) for key in ("symbol", "size", "opacity") if key in more}
    return {
        "type": "scatter",
        "mode": "markers",
        "x": numbers(x),
        "y": numbers(y),
        "name": words(name),
        "marker": look,
        **more,
    }


def whiskers(values: Sequence[float], low: Sequence[float], high: Sequence[float]) -> dict[str, Any]:
    """Return what Plotly draws as intervals around values."""
    given = np.asarray(values, float)
    return {
        "type": "data",
        "symmetric": False,
        "array": numbers(np.asarray(high, float) - given),
        "arrayminus": numbers(given - np.asarray(low, float)),
        "width": 0,
        "thickness": 1.4,
    }


def axis(title: str, span: Sequence[float | None] | None = None, ticks: Mapping[float, str] | None = None) -> Chart:
    """Return an axis with its title, from one number to another, with names in place of numbers at some places."""
    named = {} if ticks is None else {"tickvals": list(ticks), "ticktext": [words(name) for name in ticks.values()]}
    return {"title": {"text": words(title)}, **({} if span is None else {"range": list(span)}), **named}


def figure(traces: Sequence[Trace], x: Chart, y: Chart, **layout: Any) -> Chart:
    """Return a figure; further layout is Plotly's."""
    return {"data": list(traces), "layout": {"xaxis": x, "yaxis": y, **layout}}


def rule(at: float, along: str, **look: Any) -> dict[str, Any]:
    """Return a thin line across the whole figure at a value of the axis ``along``, "x" or "y"."""
    other = "y" if along == "x" else "x"
    ends = {f"{along}0": at, f"{along}1": at, f"{other}0": 0, f"{other}1": 1, f"{other}ref": "paper"}
    return {"type": "line", **ends, "line": {"color": QUIET, "width": 1, **look}}
