"""One row a ground truth: what an estimator did with it. Everything in a score is a function of this table."""

import csv
import io
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from warehouse_sim.errors import EvaluationError
from warehouse_sim.output import write_bytes
from warehouse_sim.schema import FREE, UNDER_A_STACK

_WHOLE = ("scene_id", "image_id", "gt_index", "obj_id", "prediction", "stacked")
_TEXT = ("class_name", "object_name", "face", "verdict", "limiting_error")

_ROUNDING = 1e-9
"""Metres below which a slack is what was requested: poses are read from decimal text."""


@dataclass(frozen=True, eq=False)
class ErrorTable:
    """Columns of equal length n; a missed ground truth has infinite errors and prediction -1."""

    scene_id: Int[np.ndarray, " n"]
    image_id: Int[np.ndarray, " n"]
    gt_index: Int[np.ndarray, " n"]
    """Position of the ground truth among the targets of its image."""
    obj_id: Int[np.ndarray, " n"]
    class_name: Shaped[np.ndarray, " n"]
    object_name: Shaped[np.ndarray, " n"]
    """Name of the CAD geometry."""
    distance: Float[np.ndarray, " n"]
    """From the camera to the true object origin (m)."""
    visible_fraction: Float[np.ndarray, " n"]
    illuminance: Float[np.ndarray, " n"]
    """Mean of the visible surface (lx), nan where the dataset has none."""
    diameter: Float[np.ndarray, " n"]
    """Of the object (m)."""
    prediction: Int[np.ndarray, " n"]
    """Row of the estimate in the predictions file, counted from 0; -1 for a miss."""
    score: Float[np.ndarray, " n"]
    """Confidence of the estimate; -inf for a miss."""
    add: Float[np.ndarray, " n"]
    """Mean distance under the best symmetry (m)."""
    add_shape: Float[np.ndarray, " n"]
    """The same under the best symmetry of the shape, whatever is printed on it (m); never more than ``add``."""
    add_s: Float[np.ndarray, " n"]
    """Mean distance to the nearest point (m)."""
    mssd: Float[np.ndarray, " n"]
    """Largest distance under the best symmetry (m)."""
    surface_rms: Float[np.ndarray, " n"]
    """RMS distance of the surface under the best symmetry (m): what ``error_bound`` bounds."""
    error_bound: Float[np.ndarray, " n"]
    """What the estimator says of that distance: exceeded in one case of ten (m); nan where it says nothing."""
    rotation: Float[np.ndarray, " n"]
    """Angle (rad) under the symmetry that is best by MSSD, as are all columns below."""
    translation: Float[np.ndarray, " n"]
    """Offset of the object origin (m)."""
    within_5cm_5deg: Float[np.ndarray, " n"]
    """1 where some symmetry has both errors under 5 cm and 5 degrees, else 0."""
    face: Shaped[np.ndarray, " n"]
    """Side of the object that is approached: "-x", "+x", "-y" or "+y"."""
    verdict: Shaped[np.ndarray, " n"]
    """Whether a truck takes it by that side, "free" or why not; "" where the dataset does not say."""
    stacked: Int[np.ndarray, " n"]
    """1 where it is known to stand on another pallet or under one, else 0."""
    clearance: Float[np.ndarray, " n"]
    """What the true pose leaves around the tines at the side that is requested (m); nan without pockets.

    No estimate can be requested more. A front may mean another side; what is evaluated depends on no estimate.
    """
    depth: Float[np.ndarray, " n"]
    """Along the insertion axis at the entry of that side (m)."""
    lateral: Float[np.ndarray, " n"]
    """Sideways at the entry (m)."""
    vertical: Float[np.ndarray, " n"]
    """Upwards at the entry (m)."""
    yaw: Float[np.ndarray, " n"]
    """About the vertical axis (rad)."""
    pitch: Float[np.ndarray, " n"]
    """Tip of the fork up or down (rad)."""
    slack_lateral: Float[np.ndarray, " n"]
    """Clearance left beside the tines (m), negative on collision, nan for objects without pockets.

    This slack and the next three are -inf for a miss and for an estimate that is upside down, reversed or at a wrong
    face.
    """
    slack_vertical: Float[np.ndarray, " n"]
    """Clearance left above or below the tines (m)."""
    slack_depth: Float[np.ndarray, " n"]
    """Clearance left along the tines (m), negative where they stop too deep or too short."""
    slack_mesh: Float[np.ndarray, " n"]
    """Clearance to the pallet's own mesh, damage included (m), at most 0.05; -inf beside the lanes."""
    limiting_error: Shaped[np.ndarray, " n"]
    """Error that uses up most clearance, one of ``FAILURE_AXES``; "missed", or "" without pockets."""

    def __len__(self) -> int:
        return len(self.scene_id)

    def select(self, rows: Bool[np.ndarray, " n"]) -> "ErrorTable":
        """Return the rows where ``rows`` is true."""
        return ErrorTable(**{name: column[rows] for name, column in self.columns().items()})

    def columns(self) -> dict[str, np.ndarray]:
        """Return all columns by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def found(self) -> Bool[np.ndarray, " n"]:
        """Which ground truths have an estimate."""
        return self.prediction >= 0

    @property
    def has_pockets(self) -> Bool[np.ndarray, " n"]:
        """Which ground truths have pockets, so that docking can be judged."""
        return ~np.isnan(self.slack_lateral)

    @property
    def dockable(self) -> Bool[np.ndarray, " n"]:
        """Which ground truths docking is evaluated of: a truck can take them, as far as the dataset says, and alone."""
        return self.has_pockets & np.isin(self.verdict, ("", FREE)) & (self.stacked == 0)

    def evaluated(self, margin: float = 0.0) -> Bool[np.ndarray, " n"]:
        """Return which of them have ``margin`` (m) to spare at the true pose."""
        return self.dockable & (self.clearance >= margin - _ROUNDING)

    @property
    def slack(self) -> Float[np.ndarray, " n"]:
        """Clearance around the tines to the pallet's own surface (m), -inf where they stop too deep or too short."""
        return np.where(self.slack_depth < -_ROUNDING, -np.inf, self.slack_mesh)

    @property
    def slack_nominal(self) -> Float[np.ndarray, " n"]:
        """The same to the walls of the nominal pockets (m)."""
        clearance = np.minimum(self.slack_lateral, self.slack_vertical)
        return np.where(self.slack_depth < -_ROUNDING, -np.inf, clearance)

    def docks(self, margin: float = 0.0) -> Bool[np.ndarray, " n"]:
        """Return which ground truths are docked with ``margin`` (m) to spare; none without pockets."""
        return self.slack >= margin - _ROUNDING

    def docks_nominal(self, margin: float = 0.0) -> Bool[np.ndarray, " n"]:
        """Return the same by the nominal pockets alone."""
        return self.slack_nominal >= margin - _ROUNDING

    def as_stacks(self) -> "ErrorTable":
        """Return the rows of stacks, each to be taken with what stands on it."""
        mine = self.select(self.stacked == 1)
        whole = np.where(mine.verdict == UNDER_A_STACK, FREE, mine.verdict)
        return replace(mine, stacked=np.zeros_like(mine.stacked), verdict=whole)


def table_from_rows(rows: list[dict[str, Any]]) -> ErrorTable:
    """Assemble rows with all column names into a table."""
    names = [field.name for field in fields(ErrorTable)]
    return ErrorTable(**{name: np.array([row[name] for row in rows], dtype=_dtype(name)) for name in names})


def table_from_columns(parts: list[dict[str, Any]]) -> ErrorTable:
    """Join parts with all column names into a table, by scene, image and place in the image."""
    whole = {
        name: np.concatenate([np.asarray(part[name], dtype=_dtype(name)) for part in parts] or [np.zeros(0)])
        for name in (field.name for field in fields(ErrorTable))
    }
    whole = {name: column.astype(_dtype(name), copy=False) for name, column in whole.items()}
    order = np.lexsort((whole["gt_index"], whole["image_id"], whole["scene_id"]))
    return ErrorTable(**{name: column[order] for name, column in whole.items()})


def write_table(table: ErrorTable, path: Path) -> None:
    """Write the table as CSV with seven significant digits."""
    columns = table.columns()
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow([f"{value:.7g}" if isinstance(value, float) else value for value in row])
    write_bytes(path, text.getvalue().encode("utf-8"))


def read_table(path: Path) -> ErrorTable:
    """Read a table that ``write_table`` wrote.

    Raises:
        EvaluationError: The file is missing or lacks a column.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file, restval=""))
        return table_from_rows(rows)
    except (OSError, KeyError, ValueError, OverflowError, csv.Error) as problem:
        raise EvaluationError(f"{path}: is not a table of pose errors ({problem}); run evaluate again") from problem


def _dtype(column: str) -> type:
    return np.int64 if column in _WHOLE else np.str_ if column in _TEXT else np.float64
