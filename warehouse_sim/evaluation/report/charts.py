"""The charts of a report, each from error tables or training curves to a figure."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.viewing.page.template import Chart
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, TINE_WIDTH, DockingFace
from warehouse_sim.evaluation.docking.insertion import insertion_depth
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.report.figure import PALETTE, QUIET, Trace, axis, dots, figure, line, rule
from warehouse_sim.evaluation.summary import accuracy_curve
from warehouse_sim.evaluation.trust import risk_coverage, succeeded

_PASS, _FAIL = PALETTE[0], PALETTE[1]
_DASHES = ("solid", "dash", "dashdot", "dot")

Column = Float[np.ndarray, " n"]
Passed = Bool[np.ndarray, " n"]


def accuracy_chart(tables: Mapping[str, ErrorTable], marks: Sequence[int]) -> Chart:
    """Plot the fraction of objects with an ADD below each part of their diameter; misses never come below."""
    percent = np.linspace(0.0, 10.0, 201)
    lines = [
        line(percent, 100.0 * accuracy_curve(table.add / table.diameter * 100.0, percent), name, color)
        for color, (name, table) in zip(_cycle(len(tables)), tables.items(), strict=True)
    ]
    return figure(
        lines,
        axis("ADD below this part of the diameter (%)", (0, 10)),
        axis("objects (%)", (0, 101)),
        shapes=[rule(mark, "x", dash="dash") for mark in marks],
        showlegend=True,
    )


def docking_chart(tables: Mapping[str, ErrorTable]) -> Chart:
    """Plot the fraction of objects with pockets that dock, over the clearance left for control errors."""
    margin, lines = np.linspace(0.0, 30.0, 301), []
    for color, (name, table) in zip(_cycle(len(tables)), tables.items(), strict=True):
        clearance = 1000.0 * table.clearance[table.dockable]
        slack_mm = np.minimum(1000.0 * table.slack[table.dockable], clearance)
        # Who cannot leave a margin at the true pose is not requested it.
        docked, evaluated = (
            len(values) - np.searchsorted(np.sort(values), margin - 1e-6, side="left")
            for values in (slack_mm, clearance)
        )
        fraction = np.where(evaluated > 0, docked / np.maximum(evaluated, 1), np.nan)
        lines.append(line(margin, 100.0 * fraction, name, color))
    return figure(
        lines, axis("clearance that must be left (mm)", (0, 30)), axis("docked (%)", (0, 101)), showlegend=True
    )


def sweep_chart(table: ErrorTable, faces: Sequence[DockingFace]) -> Chart:
    """Plot lateral error against yaw, with the region in which level tines clear the walls of each kind of side."""
    rows = table.select(table.found & table.dockable)
    traces = []
    for index, (beside, length) in enumerate(_sides(faces)):
        outline = _clear_region(beside, length)
        label = f"clearance in {1000.0 * (2.0 * beside + TINE_WIDTH):g} mm pockets"
        x, y = 100.0 * outline[:, 0], np.rad2deg(outline[:, 1])
        traces.append(line(x, y, label, QUIET, dash=_DASHES[index % 4], width=1))
    reach = (18.0, 9.0)
    traces += _scatter(100.0 * rows.lateral, np.rad2deg(rows.yaw), rows.docks(), reach)
    return figure(
        traces, _reaching("lateral error at the entry (cm)", reach[0]), _reaching("yaw error (deg)", reach[1])
    )


def offset_chart(table: ErrorTable) -> Chart:
    """Plot estimates from above: where the approached side was believed to be, seen from the vehicle.

    A line marks the depth error from which the heel of the tines pushes the object.
    """
    rows = table.select(table.found)
    passed = rows.docks() if rows.dockable.any() else None
    reach = (18.0, 18.0)
    return figure(
        _scatter(-100.0 * rows.lateral, 100.0 * rows.depth, passed, reach),
        _reaching("← left \u2003 lateral error (cm) \u2003 right →", reach[0]),
        _reaching("← near \u2003 depth error (cm) \u2003 far →", reach[1]),
        shapes=[] if passed is None else [rule(100.0 * HEEL_GAP, "y", dash="dash")],
        annotations=[] if passed is None else [_note(100.0 * HEEL_GAP, "the heel touches")],
    )


def histogram_chart(table: ErrorTable) -> Chart:
    """Plot how ADD is spread; the last bar holds everything beyond."""
    edges = np.linspace(0.0, 15.0, 31)
    counts = np.histogram(np.minimum(100.0 * table.add[table.found], 15.0 - 1e-9), edges)[0]
    bars = {"type": "bar", "x": ((edges[1:] + edges[:-1]) / 2).tolist(), "y": counts.tolist(), "name": "objects"}
    ticks = {float(at): f"{at}" if at < 15 else f">{at}" for at in range(0, 16, 3)}
    return figure(
        [bars | {"marker": {"color": PALETTE[0]}}], axis("ADD (cm)", (0, 15), ticks), axis("objects"), bargap=0.1
    )


def failure_chart(failures: Mapping[str, int]) -> Chart:
    """Plot how many objects cannot be docked, by the error to blame."""
    names, counts = [name.replace("_", " ") for name in failures][::-1], list(failures.values())[::-1]
    bars = {"type": "bar", "orientation": "h", "y": names, "x": counts, "text": counts, "name": "objects"}
    return figure([bars | {"marker": {"color": _FAIL}}], axis("objects that cannot be docked"), axis(""))


def risk_chart(table: ErrorTable) -> Chart:
    """Plot which fraction of the kept estimates fails when the least certain are rejected, over how many are kept.

    Beside it stands a ranking that knows the ground truth, and one that knows nothing.
    """
    found = table.select(table.found)
    right = succeeded(found)
    traces = []
    for score, color, dash, label in (
        (found.score, PALETTE[0], "solid", "by score"),
        (right + np.linspace(0.0, 0.5, len(right)), QUIET, "dash", "perfect ranking"),
    ):
        curve = risk_coverage(score, right)
        traces.append(line(100.0 * curve.coverage, 100.0 * curve.risk, label, color, dash=dash))
    risk = 100.0 * float((~right).mean())
    traces.append(line([0.0, 100.0], [risk, risk], "no ranking", QUIET, width=1))
    return figure(traces, axis("estimates kept (%)", (0, 100)), axis("of these, wrong (%)") | {"rangemode": "tozero"})


def training_chart(curves: Sequence[Mapping[str, float]], columns: Sequence[str], label: str) -> Chart:
    """Plot columns of a run's curves that share a unit over the minutes of training."""
    traces = []
    for color, name in zip(_cycle(len(columns)), columns, strict=True):
        rows = [row for row in curves if name in row and "seconds" in row]
        x, y = [row["seconds"] / 60.0 for row in rows], [row[name] for row in rows]
        traces.append(line(x, y, name.removeprefix("val_").replace("_", " "), color, mode="lines+markers"))
    zero = {"rangemode": "tozero"}
    return figure(traces, axis("minutes") | zero, axis(label) | zero, showlegend=len(columns) > 1)


def _cycle(count: int) -> list[str]:
    return [PALETTE[index % len(PALETTE)] for index in range(count)]


def _reaching(title: str, reach: float) -> Chart:
    return axis(title, (-1.05 * reach, 1.05 * reach))


def _note(y: float, text: str) -> dict[str, Any]:
    return {"x": 1, "xref": "paper", "y": y, "text": text, "showarrow": False, "xanchor": "right", "yanchor": "bottom"}


def _scatter(x: Column, y: Column, passed: Passed | None, reach: tuple[float, float]) -> list[Trace]:
    """Return points, coloured by whether they pass; what lies beyond ``reach`` sits on the border as a triangle."""
    beyond = (np.abs(x) > reach[0]) | (np.abs(y) > reach[1])
    x, y = np.clip(x, -reach[0], reach[0]), np.clip(y, -reach[1], reach[1])
    kinds: list[tuple[Passed, str, str]] = [(np.ones(len(x), bool), _PASS, "estimates")]
    if passed is not None:
        kinds = [(passed, _PASS, "docks"), (~passed, _FAIL, "fails")]
    traces = []
    for chosen, color, label in kinds:
        symbols = np.where(beyond[chosen], "triangle-up", "circle").tolist()
        traces.append(dots(x[chosen], y[chosen], label, color, symbol=symbols, size=6, opacity=0.7))
    return traces


def _sides(faces: Sequence[DockingFace]) -> list[tuple[float, float]]:
    """Return the kinds of pocket as clearance beside a tine and insertion depth (m), narrow ones first."""
    pockets = [pocket for face in faces for pocket in face.pockets]
    return sorted({(round((p.size[1] - TINE_WIDTH) / 2.0, 6), insertion_depth(p)) for p in pockets})


def _clear_region(beside: float, length: float) -> Float[np.ndarray, "5 2"]:
    """Outline of |y| <= beside and |y + length * sin(yaw)| <= beside, as lateral (m) and yaw (rad)."""
    sine = np.array([0.0, -2.0, 0.0, 2.0, 0.0]) * beside / length
    lateral = np.array([beside, beside, -beside, -beside, beside])
    return np.stack([lateral, np.arcsin(np.clip(sine, -1.0, 1.0))], axis=1)
