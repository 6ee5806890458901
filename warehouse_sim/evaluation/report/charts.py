"""The charts of a report, each from error tables or training curves to an SVG element."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.evaluation.docking.fork import HEEL_GAP, TINE_WIDTH, DockingFace
from warehouse_sim.evaluation.docking.insertion import insertion_depth
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.report.figure import PALETTE, chart
from warehouse_sim.evaluation.summary import accuracy_curve
from warehouse_sim.evaluation.trust import risk_coverage, succeeded

_PASS, _FAIL, _QUIET = PALETTE[0], PALETTE[1], "#8b949e"

Column = Float[np.ndarray, " n"]
Passed = Bool[np.ndarray, " n"]


def accuracy_chart(tables: Mapping[str, ErrorTable], marks: Sequence[int]) -> str:
    """Draw the fraction of objects with an ADD below each part of their diameter; misses never come below."""
    percent = np.linspace(0.0, 10.0, 400)
    with chart() as drawing:
        axes = drawing.axes
        for color, (name, table) in zip(_cycle(len(tables)), tables.items(), strict=True):
            fraction = accuracy_curve(table.add / table.diameter * 100.0, percent)
            axes.plot(percent, 100.0 * fraction, color=color, label=name)
        for mark in marks:
            axes.axvline(mark, color=_QUIET, linewidth=0.8, linestyle=(0, (3, 3)))
        axes.set(xlim=(0, 10), ylim=(0, 101), xlabel="ADD below this part of the diameter (%)", ylabel="objects (%)")
        axes.legend(loc="lower right")
        return drawing.svg()


def docking_chart(tables: Mapping[str, ErrorTable]) -> str:
    """Draw the fraction of objects with pockets that dock, over the clearance left for control errors."""
    margin = np.linspace(0.0, 30.0, 301)
    with chart() as drawing:
        axes = drawing.axes
        for color, (name, table) in zip(_cycle(len(tables)), tables.items(), strict=True):
            clearance = 1000.0 * table.clearance[table.dockable]
            slack_mm = np.minimum(1000.0 * table.slack[table.dockable], clearance)
            # Who cannot leave a margin at the true pose is not requested it.
            docked, evaluated = (
                len(values) - np.searchsorted(np.sort(values), margin - 1e-6, side="left")
                for values in (slack_mm, clearance)
            )
            fraction = np.where(evaluated > 0, docked / np.maximum(evaluated, 1), np.nan)
            axes.plot(margin, 100.0 * fraction, color=color, label=name)
        axes.set(xlim=(0, 30), ylim=(0, 101), xlabel="clearance that must be left (mm)", ylabel="docked (%)")
        axes.legend(loc="lower left")
        return drawing.svg()


def sweep_chart(table: ErrorTable, faces: Sequence[DockingFace]) -> str:
    """Draw lateral error against yaw, with the region in which level tines clear the walls of each kind of side."""
    rows = table.select(table.found & table.dockable)
    lateral_cm, yaw_deg = 100.0 * rows.lateral, np.rad2deg(rows.yaw)
    with chart() as drawing:
        axes = drawing.axes
        for index, (beside, length) in enumerate(_sides(faces)):
            outline = _clear_region(beside, length)
            style = {"color": _QUIET, "linewidth": 1.0, "linestyle": ("-", "--", "-.", ":")[index % 4]}
            label = f"clearance in {1000.0 * (2.0 * beside + TINE_WIDTH):g} mm pockets"
            axes.plot(100.0 * outline[:, 0], np.rad2deg(outline[:, 1]), label=label, **style)
        _scatter(axes, lateral_cm, yaw_deg, rows.docks(), (18.0, 9.0))
        axes.set(xlabel="lateral error at the entry (cm)", ylabel="yaw error (deg)")
        drawing.legend_above()
        return drawing.svg()


def offset_chart(table: ErrorTable) -> str:
    """Draw estimates from above: where the approached side was believed to be, seen from the vehicle.

    A line marks the depth error from which the heel of the tines pushes the object.
    """
    rows = table.select(table.found)
    passed = rows.docks() if rows.dockable.any() else None
    with chart() as drawing:
        axes = drawing.axes
        axes.axhline(0, color=_QUIET, linewidth=0.8)
        axes.axvline(0, color=_QUIET, linewidth=0.8)
        if passed is not None:
            style = {"color": _QUIET, "linewidth": 0.8, "linestyle": (0, (3, 3))}
            axes.axhline(100.0 * HEEL_GAP, label="the heel touches", **style)
        _scatter(axes, -100.0 * rows.lateral, 100.0 * rows.depth, passed, (18.0, 18.0))
        axes.set(
            xlabel="← left \u2003 lateral error (cm) \u2003 right →",
            ylabel="← near \u2003 depth error (cm) \u2003 far →",
        )
        if passed is not None:
            drawing.legend_above()
        return drawing.svg()


def histogram_chart(table: ErrorTable) -> str:
    """Draw how ADD is spread; the last bar holds everything beyond."""
    values = np.minimum(100.0 * table.add[table.found], 15.0 - 1e-9)
    with chart() as drawing:
        axes = drawing.axes
        axes.hist(values, bins=np.linspace(0.0, 15.0, 31), color=PALETTE[0], alpha=0.85, rwidth=0.9)
        axes.grid(visible=False, axis="x")
        ticks = np.arange(0, 16, 3)
        axes.set_xticks(ticks, [*map(str, ticks[:-1]), f">{ticks[-1]}"])
        axes.set(xlim=(0, 15), xlabel="ADD (cm)", ylabel="objects")
        axes.yaxis.get_major_locator().set_params(integer=True)
        return drawing.svg()


def failure_chart(failures: Mapping[str, int]) -> str:
    """Draw how many objects cannot be docked, by the error to blame."""
    names, counts = [name.replace("_", " ") for name in failures][::-1], list(failures.values())[::-1]
    with chart() as drawing:
        axes = drawing.axes
        bars = axes.barh(names, counts, color=_FAIL, height=0.62)
        axes.bar_label(bars, padding=4, fontsize=9)
        axes.grid(visible=False, axis="y")
        axes.set(xlim=(0, 1.15 * max(1, *counts)), xlabel="objects that cannot be docked")
        axes.xaxis.get_major_locator().set_params(integer=True)
        return drawing.svg()


def risk_chart(table: ErrorTable) -> str:
    """Draw which fraction of the kept estimates fails when the least certain are rejected, over how many are kept.

    Beside it stands a ranking that knows the ground truth, and one that knows nothing.
    """
    found = table.select(table.found)
    right = succeeded(found)
    with chart() as drawing:
        axes = drawing.axes
        for score, color, style, label in (
            (found.score, PALETTE[0], "-", "by score"),
            (right + np.linspace(0.0, 0.5, len(right)), _QUIET, (0, (3, 3)), "perfect ranking"),
        ):
            curve = risk_coverage(score, right)
            axes.plot(100.0 * curve.coverage, 100.0 * curve.risk, color=color, linestyle=style, label=label)
        axes.axhline(100.0 * float((~right).mean()), color=_QUIET, linewidth=0.8, label="no ranking")
        axes.set(xlim=(0, 100), xlabel="estimates kept (%)", ylabel="of these, wrong (%)")
        axes.set_ylim(bottom=0)
        drawing.legend_above()
        return drawing.svg()


def training_chart(curves: Sequence[Mapping[str, float]], columns: Sequence[str], label: str) -> str:
    """Draw columns of a run's curves that share a unit over the minutes of training."""
    with chart(width=4.0, height=2.9) as drawing:
        axes = drawing.axes
        for color, name in zip(_cycle(len(columns)), columns, strict=True):
            points = [(row["seconds"] / 60.0, row[name]) for row in curves if name in row and "seconds" in row]
            axes.plot(
                *zip(*points, strict=True),
                color=color,
                marker="o",
                markersize=3.5,
                label=name.removeprefix("val_").replace("_", " "),
            )
        axes.set(xlabel="minutes", ylabel=label)
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        if len(columns) > 1:
            drawing.legend_above()
        return drawing.svg()


def _cycle(count: int) -> list[str]:
    return [PALETTE[index % len(PALETTE)] for index in range(count)]


def _scatter(axes: Any, x: Column, y: Column, passed: Passed | None, reach: tuple[float, float]) -> None:
    """Draw points, coloured by whether they pass; what lies beyond ``reach`` sits on the border as a triangle."""
    beyond = (np.abs(x) > reach[0]) | (np.abs(y) > reach[1])
    x, y = np.clip(x, -reach[0], reach[0]), np.clip(y, -reach[1], reach[1])
    kinds: list[tuple[Passed, str, str | None]] = [(np.ones(len(x), bool), _PASS, None)]
    if passed is not None:
        kinds = [(passed, _PASS, "docks"), (~passed, _FAIL, "fails")]
    for chosen, color, label in kinds:
        style = {"color": color, "alpha": 0.7, "linewidths": 0}
        axes.scatter(x[chosen & ~beyond], y[chosen & ~beyond], s=14, label=label, **style)
        axes.scatter(x[chosen & beyond], y[chosen & beyond], s=22, marker="^", **style)
    axes.set(xlim=(-1.05 * reach[0], 1.05 * reach[0]), ylim=(-1.05 * reach[1], 1.05 * reach[1]))


def _sides(faces: Sequence[DockingFace]) -> list[tuple[float, float]]:
    """Return the kinds of pocket as clearance beside a tine and insertion depth (m), narrow ones first."""
    pockets = [pocket for face in faces for pocket in face.pockets]
    return sorted({(round((p.size[1] - TINE_WIDTH) / 2.0, 6), insertion_depth(p)) for p in pockets})


def _clear_region(beside: float, length: float) -> Float[np.ndarray, "5 2"]:
    """Outline of |y| <= beside and |y + length * sin(yaw)| <= beside, as lateral (m) and yaw (rad)."""
    sine = np.array([0.0, -2.0, 0.0, 2.0, 0.0]) * beside / length
    lateral = np.array([beside, beside, -beside, -beside, beside])
    return np.stack([lateral, np.arcsin(np.clip(sine, -1.0, 1.0))], axis=1)
