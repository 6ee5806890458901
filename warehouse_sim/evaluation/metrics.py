"""The numbers of a score: fractions of ground truths that pass, areas under curves, and medians."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.evaluation.error_table import ErrorTable

DIAMETER_PERCENT = (2, 5, 10)
"""Accuracy thresholds as percentages of the object's diameter."""
DOCKING_MARGIN_MM = (0, 10, 20)
"""Clearance (mm) that docking must leave to the walls for the errors of the vehicle's control."""
_POSECNN_LIMIT = 0.1


def pass_values(table: ErrorTable, percents: Sequence[int] = DIAMETER_PERCENT) -> dict[str, Float[np.ndarray, " n"]]:
    """Return for each fraction-like metric one value in 0-1 a ground truth; nan where it does not apply.

    A miss has the value 0. Names: ``<error>_<k>pct`` is the fraction with an error under k % of the diameter,
    for ``add_shape`` over the symmetries of the shape, whatever is printed on it,
    ``mssd_2cm`` and ``mssd_5cm`` serve objects without pockets, ``dock_<m>mm`` is docking with margin m
    against its own mesh, ``dock_nominal_<m>mm`` against its nominal pockets; both are evaluated of what a truck can
    take and what leaves that margin at its true pose; ``dock_gate_20mm_2.9deg`` and ``dock_gate_50mm_3deg`` are the
    threshold pairs of the literature, and ``auc_*`` are areas under the accuracy curve in their mean form ``mean(max(0,
    1 - error / limit))``.
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
    values["dock_gate_20mm_2.9deg"] = _where_dockable(table, _gate(table, 0.020, 2.9, 180.0))
    values["dock_gate_50mm_3deg"] = _where_dockable(table, _gate(table, 0.050, 3.0, 1.0))
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


def _gate(table: ErrorTable, lateral: float, yaw_deg: float, pitch_deg: float) -> np.ndarray:
    # Infinite where the estimate is upside down or reversed, which neither threshold would see.
    return (
        np.isfinite(table.slack_depth)
        & (np.abs(table.lateral) <= lateral)
        & (np.abs(np.rad2deg(table.yaw)) <= yaw_deg)
        & (np.abs(np.rad2deg(table.pitch)) <= pitch_deg)
    )


def _median(column: Float[np.ndarray, " n"]) -> float:
    # np.median would average a finite number with inf, or inf with inf, to something undefined.
    ordered = np.sort(column)
    low, high = ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]
    return float(low if low == high else (low + high) / 2.0)
