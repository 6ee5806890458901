"""All metrics of one group of ground truths, and the groups that a score is split into."""

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.files.record import Record, Whole
from warehouse_sim.evaluation.docking.insertion import FAILURE_AXES
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.intervals import fraction_intervals
from warehouse_sim.evaluation.metrics import DOCKING_MARGIN_MM, median_values, pass_values, posecnn_auc
from warehouse_sim.evaluation.stated import STATED, Number

DISTANCE_EDGES = (0.0, 2.0, 4.0, 6.0, 8.0, 12.0)
"""Lower edges (m) of the distance bins; the last bin has no end."""
VISIBLE_FRACTION_EDGES = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Lower edges of the bins by visible fraction; the last bin ends at 1."""
ILLUMINANCE_EDGES = (0.0, 50.0, 100.0, 200.0, 400.0, 800.0)
"""Lower edges (lx) of the bins by light on the visible surface; the last bin has no end."""
_AUC = "auc_add_10cm_posecnn"
RESAMPLES, RESAMPLING_SEED = 1000, 0
"""Of the scenes, for the 95 % intervals."""


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
