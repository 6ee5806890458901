"""The numbers of a score: fractions that pass, areas under curves and medians, of each group that it is split into."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.files.record import Record, Whole
from warehouse_sim.evaluation.docking.insertion import FAILURE_AXES
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.intervals import fraction_intervals
from warehouse_sim.evaluation.stated import STATED, Number

DIAMETER_PERCENT = (2, 5, 10)
"""Accuracy thresholds as percentages of the object's diameter."""
DOCKING_MARGIN_MM = (0, 10, 20)
"""Clearance (mm) that docking must leave to the walls for the errors of the vehicle's control."""
_POSECNN_LIMIT = 0.1
DISTANCE_EDGES = (0.0, 2.0, 4.0, 6.0, 8.0, 12.0)
"""Lower edges (m) of the distance bins; the last bin has no end."""
VISIBLE_FRACTION_EDGES = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Lower edges of the bins by visible fraction; the last bin ends at 1."""
ILLUMINANCE_EDGES = (0.0, 50.0, 100.0, 200.0, 400.0, 800.0)
"""Lower edges (lx) of the bins by light on the visible surface; the last bin has no end."""
_AUC = "auc_add_10cm_posecnn"
RESAMPLES, RESAMPLING_SEED = 1000, 0
"""Of the scenes, for the 95 % intervals."""


def pass_values(table: ErrorTable, percents: Sequence[int] = DIAMETER_PERCENT) -> dict[str, Float[np.ndarray, " n"]]:
    """Return for each fraction-like metric one value in 0-1 a ground truth; nan where it does not apply.

    A miss has the value 0. Names: ``<error>_<k>pct`` is the fraction with an error under k % of the diameter,
    for ``add_shape`` over the symmetries of the shape, whatever is printed on it,
    ``mssd_2cm`` and ``mssd_5cm`` serve objects without pockets, ``dock_<m>mm`` is docking with margin m
    against its own mesh, ``dock_nominal_<m>mm`` against its nominal pockets; both are evaluated of what a truck can
    take and what leaves that margin at its true pose; ``dock_gate_20mm_2.9deg``, ``dock_gate_50mm_3deg`` and
    ``dock_gate_50mm_3deg_40mm`` (sideways, yaw, up) are tolerances of the literature, and ``auc_*`` are areas under the
    accuracy curve in their mean form ``mean(max(0, 1 - error / limit))``.
    """
    values = {}
    errors = {"add": table.add, "add_shape": table.add_shape, "mssd": table.mssd, "add_s": table.add_s}
    for name, error in errors.items():
        for percent in percents:
            values[f"{name}_{percent}pct"] = (error < percent / 100.0 * table.diameter).astype(float)
    for centimetres in (2, 5):
        values[f"mssd_{centimetres}cm"] = (table.mssd < centimetres / 100.0).astype(float)
    values["pose_5cm_5deg"] = table.within_5cm_5deg
    for margin in DOCKING_MARGIN_MM:
        evaluated = table.evaluated(margin / 1000.0)
        values[f"dock_{margin}mm"] = np.where(evaluated, table.docks(margin / 1000.0), np.nan)
        values[f"dock_nominal_{margin}mm"] = np.where(evaluated, table.docks_nominal(margin / 1000.0), np.nan)
    values["dock_gate_20mm_2.9deg"] = _where_dockable(table, _gate(table, 0.020, 2.9))
    values["dock_gate_50mm_3deg"] = _where_dockable(table, _gate(table, 0.050, 3.0, pitch_deg=1.0))
    values["dock_gate_50mm_3deg_40mm"] = _where_dockable(table, _gate(table, 0.050, 3.0, vertical=0.040))
    values["auc_add_10cm"] = np.maximum(0.0, 1.0 - table.add / 0.1)
    values["auc_add_10pct"] = np.maximum(0.0, 1.0 - table.add / (0.1 * table.diameter))
    return values


def median_values(table: ErrorTable) -> dict[str, float]:
    """Return medians over all ground truths, misses counting as infinite (SI units, angles in degrees)."""
    columns = {
        "median_add": table.add,
        "median_mssd": table.mssd,
        "median_add_s": table.add_s,
        "median_translation": table.translation,
        "median_rotation_deg": np.rad2deg(table.rotation),
        "median_lateral": np.abs(table.lateral),
        "median_vertical": np.abs(table.vertical),
        "median_depth": np.abs(table.depth),
        "median_yaw_deg": np.abs(np.rad2deg(table.yaw)),
        "median_pitch_deg": np.abs(np.rad2deg(table.pitch)),
    }
    return {name: _median(column) for name, column in columns.items()}


def posecnn_auc(errors: Float[np.ndarray, " n"]) -> float:
    """Return the area under the accuracy-threshold curve as the YCB-Video toolbox of PoseCNN computes it.

    The sorted errors up to 0.1 m are summed as right-hand rectangles, which adds ``largest / (0.1 m * n)`` to the mean
    form; n counts misses (infinite errors) too.

    Args:
        errors: ADD of every ground truth (m), inf for a miss; n >= 1.
    """
    kept = np.sort(errors[errors <= _POSECNN_LIMIT])
    if kept.size == 0:
        return 0.0
    accuracy = np.arange(1, len(kept) + 1) / len(errors)
    edges = np.concatenate([[0.0], kept, [_POSECNN_LIMIT]])
    heights = np.concatenate([accuracy, accuracy[-1:]])
    return float((np.diff(edges) * heights).sum() / _POSECNN_LIMIT)


def accuracy_curve(errors: Float[np.ndarray, " n"], thresholds: Float[np.ndarray, " t"]) -> Float[np.ndarray, " t"]:
    """Return for each threshold the fraction of all ground truths with an error below it."""
    return np.searchsorted(np.sort(errors), thresholds, side="left") / len(errors)


def _where_dockable(table: ErrorTable, passed: np.ndarray) -> Float[np.ndarray, " n"]:
    return np.where(table.dockable, passed.astype(float), np.nan)


def _gate(
    table: ErrorTable, lateral: float, yaw_deg: float, pitch_deg: float = np.inf, vertical: float = np.inf
) -> np.ndarray:
    # Infinite where the estimate is upside down or reversed, which neither threshold would see.
    return (
        np.isfinite(table.slack_depth)
        & (np.abs(table.lateral) <= lateral)
        & (np.abs(np.rad2deg(table.yaw)) <= yaw_deg)
        & (np.abs(np.rad2deg(table.pitch)) <= pitch_deg)
        & (np.abs(table.vertical) <= vertical)
    )


def _median(column: Float[np.ndarray, " n"]) -> float:
    # np.median would average a finite number with inf, or inf with inf, to something undefined.
    ordered = np.sort(column)
    low, high = ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]
    return float(low if low == high else (low + high) / 2.0)


@dataclass(frozen=True, eq=False)
class Summary(Record):
    """The metrics of one group."""

    label: str
    """What the group is: "all", a class, or a range."""
    gt_count: Whole
    """Ground truths that count, found or not: the denominator of every share."""
    found_count: Whole
    """Ground truths with an estimate."""
    dockable_count: Whole
    """Ground truths that docking is evaluated of: a truck can take them, as far as the dataset says, and alone."""
    metrics: dict[str, Number] = field(metadata=STATED)
    """By name; inf is a median among misses, nan is a metric that applies to nothing in the group."""
    intervals: dict[str, tuple[Number, Number]] = field(metadata=STATED)
    """95 % intervals of the fraction-like metrics."""

    def __post_init__(self) -> None:
        for name, value in self.metrics.items():
            is_fraction = not name.startswith("median_") and name != _AUC
            if is_fraction and not np.isnan(value) and not (0.0 <= value <= 1.0 and name in self.intervals):
                raise ValueError(f"metrics: {name} must be 0-1 with an interval, or null, found {value}")


def summarise(label: str, table: ErrorTable) -> Summary:
    """Compute every metric of ``table``, which may be empty."""
    columns, values = pass_values(table), {}
    for name, column in columns.items():
        applies = ~np.isnan(column)
        values[name] = float(column[applies].mean()) if applies.any() else np.nan
    if len(table):
        values[_AUC] = posecnn_auc(table.add)
        values |= median_values(table)
    intervals = fraction_intervals(columns, table.scene_id, RESAMPLES, RESAMPLING_SEED)
    found, dockable = int(table.found.sum()), int(table.dockable.sum())
    return Summary(label, len(table), found, dockable, values, intervals)


def summarise_groups(table: ErrorTable) -> dict[str, tuple[Summary, ...]]:
    """Return the same metrics by class, object, distance, visible fraction and light; and, where known, of stacks."""
    groups = {
        name: tuple(summarise(label, table.select(rows)) for label, rows in group)
        for name, group in split_groups(table).items()
    }
    if (table.verdict != "").any():
        stacks = {"alone": table.select(table.stacked == 0), "stacked": table.as_stacks()}
        groups["stacking"] = tuple(summarise(label, part) for label, part in stacks.items())
    return groups


def split_groups(table: ErrorTable) -> dict[str, list[tuple[str, Bool[np.ndarray, " n"]]]]:
    """Return the groups of each split, by the name of what it splits by -> (label, rows).

    Ground truths whose light is not known are in no bin of "illuminance".
    """
    classes, objects = (sorted(set(names.tolist())) for names in (table.class_name, table.object_name))
    return {
        "class": [(name, table.class_name == name) for name in classes],
        "object": [(name, table.object_name == name) for name in objects],
        "distance": _bins(table.distance, (*DISTANCE_EDGES, np.inf), " m"),
        "visible_fraction": _bins(table.visible_fraction, (*VISIBLE_FRACTION_EDGES, 1.0), ""),
        "illuminance": _bins(table.illuminance, (*ILLUMINANCE_EDGES, np.inf), " lx"),
    }


def docking_failures(table: ErrorTable) -> dict[str, int]:
    """Count the ground truths that cannot be docked (no margin) by the error to blame, "missed" for no estimate."""
    failed = table.limiting_error[table.evaluated() & ~table.docks()]
    return {axis: int((failed == axis).sum()) for axis in (*FAILURE_AXES, "missed")}


def docking_left_out(table: ErrorTable) -> dict[str, int]:
    """Count the ground truths with pockets for which docking is not evaluated, by reason, the most frequent first.

    Those in stacks come under "stacked" whatever their faces; those that a truck can take and that do not leave a
    margin at the true pose under "no clearance for 20 mm", which holds for that margin alone.
    """
    pockets, stacked = table.has_pockets, table.stacked == 1
    blocked = Counter(table.verdict[pockets & ~table.dockable & ~stacked].tolist())
    tight = {
        f"no clearance for {k} mm": int((table.dockable & ~table.evaluated(k / 1000.0)).sum())
        for k in DOCKING_MARGIN_MM
    }
    counts = {"stacked": int((pockets & stacked).sum())} | dict(blocked.most_common()) | tight
    return {reason: count for reason, count in counts.items() if count}


def _bins(
    values: Float[np.ndarray, " n"], edges: tuple[float, ...], unit: str
) -> list[tuple[str, Bool[np.ndarray, " n"]]]:
    bins = []
    for low, high in pairwise(edges):
        last = high == edges[-1]
        label = f"over {low:g}{unit}" if np.isinf(high) else f"{low:g}-{high:g}{unit}"
        bins.append((label, (values >= low) & ((values <= high) if last else (values < high))))
    return bins
