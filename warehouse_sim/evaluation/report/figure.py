"""One look for all charts: inline SVG whose ink follows the page's light or dark scheme."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from warehouse_sim.optional import require

PALETTE = ("#2f6fde", "#e07b1f", "#1d9a78", "#8a55d7", "#c2405a", "#6b7785")
_INK = "#101418"
"""Stands for the page's text colour, which replaces it in the SVG."""
_STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "warehouse-sim",
    "text.parse_math": False,
    "font.size": 10.0,
    "font.sans-serif": ["DejaVu Sans"],
    "text.color": _INK,
    "axes.labelcolor": _INK,
    "axes.edgecolor": _INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#8b949e",
    "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "xtick.color": _INK,
    "ytick.color": _INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "lines.linewidth": 1.8,
}


class Chart:
    """A matplotlib axes on its way to SVG."""

    def __init__(self, figure: Any, axes: Any) -> None:
        self.axes = axes
        self._figure = figure

    def legend_above(self) -> None:
        """Put the legend over the axes, where it hides nothing."""
        self._figure.legend(loc="outside upper center", ncols=2, columnspacing=1.2, handletextpad=0.5)

    def svg(self, prefix: str = "") -> str:
        """Return the chart as an ``<svg>`` element.

        Args:
            prefix: Put before every name in it, so that no two charts of a page share one.
        """
        buffer = io.StringIO()
        metadata = {"Date": None, "Creator": None, "Format": None, "Type": None}
        self._figure.savefig(buffer, format="svg", transparent=True, metadata=metadata)
        text = buffer.getvalue()
        text = text[text.index("<svg") :].replace(_INK, "currentColor")
        return re.sub(r'(\bid="|xlink:href="#|url\(#)', rf"\g<1>{prefix}", text) if prefix else text


@contextmanager
def chart(width: float = 4.6, height: float = 3.1) -> Iterator[Chart]:
    """Open a chart of a size in inches; draw into ``.axes`` and take ``.svg()`` before it closes.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """
    matplotlib = require("matplotlib", "report", "for the charts of a report")
    figure_module = require("matplotlib.figure", "report", "for the charts of a report")
    with matplotlib.rc_context(_STYLE):
        figure = figure_module.Figure(figsize=(width, height), layout="constrained")
        yield Chart(figure, figure.add_subplot())
