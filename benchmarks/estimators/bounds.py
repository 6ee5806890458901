"""How often the error bound that an estimator states is true, by distance: it was fitted on val, over all distances.

python -m benchmarks.estimators.bounds     # after python -m benchmarks.estimators
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import tyro

from benchmarks.estimators.score import SETTINGS, Setting, place_of
from trainings.data import FOLDER, SCORED, made
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.calibrate import surface_distance
from warehouse_sim.estimators.pose.densefusion.calibration import read_calibration
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.registries import trained_names
from warehouse_sim.evaluation import Scores, read_scores
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.resources import data_folder

EDGES = (0.0, 4.0, 6.0, 8.0, 10.0, np.inf)
"""Distances (m) between which the bound is counted."""
EVERYWHERE = "all"
"""Label of the row that counts every distance."""
_LEAST_COUNTED = 10
"""A fraction of fewer objects says nothing."""


def main(folder: Path = FOLDER, setting: str = SETTINGS[-1].name) -> None:
    """Print for each bundled model the fraction of objects whose error stayed below the stated bound.

    Args:
        folder: Where data and scores are kept.
        setting: Which of the settings.
    """
    chosen = next(item for item in SETTINGS if item.name == setting)
    for data in SCORED:
        root = made(data, folder)
        for method in trained_names():
            place = place_of(folder / "scores" / method / data.folder_name, chosen)
            found = covered(data_folder("models") / method, root, read_scores(place), chosen)
            print(f"{data.folder_name} {method:24s}", *(f"{row['label']}: {100 * row['value']:.0f} %" for row in found))


def covered(model: Path, data: Path, scores: Scores, setting: Setting) -> list[dict]:
    """Return the fraction of estimated objects whose surface is closer to ground truth than the bound, by distance.

    Args:
        model: Folder of the model, which holds the calibration.
        data: Dataset that was scored.
        scores: What it reached there.
        setting: How poses were selected and refined.

    Returns:
        ``label``, ``value``, ``interval`` (95 %, over scenes) and ``n`` of each range that holds enough objects.
    """
    curve = read_calibration(model).get(*setting.config.way)
    if curve is None:
        return []
    shapes = {shape.obj_id: shape for shape in PoseRun.read(model).objects}
    gt = {
        (image.scene_id, image.image_id, target.gt_index): target.T_camera_object
        for image in DatasetReader(data).images(scores.dataset["split"])
        for target in image.targets
    }
    table = scores.table.select(scores.table.found)
    holds = np.empty(len(table))
    for row, key in enumerate(zip(table.scene_id, table.image_id, table.gt_index, strict=True)):
        estimate = scores.estimates[table.prediction[row]]
        shape = shapes[estimate.obj_id]
        error = surface_distance(estimate.T_camera_object, gt[tuple(map(int, key))], shape)
        # Of a score that uncertainty has made, the curve knows nothing; then the bound stands beside the pose.
        nominal = estimate.error_bound
        holds[row] = error <= (curve.bound_at(estimate.score) * shape.diameter if nominal is None else nominal)
    ranges = {EVERYWHERE: np.ones(len(table), dtype=bool)}
    for low, high in pairwise(EDGES):
        label = f"over {low:g} m" if np.isinf(high) else f"{low:g}-{high:g} m"
        ranges[label] = (low <= table.distance) & (table.distance < high)
    return [
        _row(label, holds[rows], table.scene_id[rows]) for label, rows in ranges.items() if rows.sum() >= _LEAST_COUNTED
    ]


def as_markdown(found: Sequence[tuple[str, list[dict]]]) -> list[str]:
    """Return lines of a table: a row a dataset, a column a range of distances."""
    labels = list(dict.fromkeys(row["label"] for _, rows in found for row in rows))
    lines = ["| | " + " | ".join(labels) + " |", "|---|" + "---|" * len(labels)]
    for name, rows in found:
        by_label = {row["label"]: row for row in rows}
        lines.append(f"| {name} | " + " | ".join(_cell(by_label.get(label)) for label in labels) + " |")
    return lines


def _row(label: str, holds: np.ndarray, scene_id: np.ndarray) -> dict:
    low, high = fraction_interval(holds, scene_id, 1000, np.random.default_rng(0))
    value = round(float(holds.mean()), 5)
    return {"label": label, "value": value, "interval": [round(low, 5), round(high, 5)], "n": len(holds)}


def _cell(row: dict | None) -> str:
    if row is None:
        return "-"
    low, high = row["interval"]
    return f"{100 * row['value']:.0f} [{100 * low:.0f}, {100 * high:.0f}]"


if __name__ == "__main__":
    tyro.cli(main)
