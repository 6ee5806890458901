"""Predict and score one model on one split, and take out of the score what the tables show."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.errors import EvaluationError
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.predict import read_images, require_known
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.evaluation import Scores, evaluate, read_scores, write_scores
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.evaluation.summary import Summary, pass_values
from warehouse_sim.learning.run_folder import WEIGHTS
from warehouse_sim.schema import PoseEstimate

FRACTIONS = (
    "add_2pct",
    "add_5pct",
    "add_10pct",
    "add_shape_10pct",
    "pose_5cm_5deg",
    "dock_0mm",
    "dock_10mm",
    "dock_20mm",
)
DOCKING_RANGE = (2.0, 7.0)
"""Distances (m) between which docking is requested: nearer a forklift is already entering, farther it still drives."""

_IMAGES_AT_ONCE = 8


@dataclass(frozen=True)
class Setting:
    """How the poses that points propose become one."""

    name: str
    """As it is called in tables."""
    config: PredictConfig
    """Settings of prediction."""


SELECTIONS = tuple(
    Setting(name, PredictConfig(selection=name, refine="none"))
    for name in ("argmax", "weighted", "weighted-50", "consensus")
)
"""Every selection, without ICP."""
SETTINGS = (
    SELECTIONS[0],
    SELECTIONS[-1],
    Setting("consensus + ICP", PredictConfig(selection="consensus", refine="icp")),
)
"""What the tables of all models show."""
VERIFICATION = Setting("consensus + verification", PredictConfig(selection="consensus", refine="verify"))
"""Shown beside them for pallets: several hypotheses of each, decided by the depth image."""


def score(model: Path, data: Path, split: str, settings: Sequence[Setting], folder: Path) -> dict[str, Scores]:
    """Predict ``split`` with each of the settings, reading every image once; keep predictions and scores in ``folder``.

    Predictions that are newer than the model's weights are not regenerated, nor are scores of them that are newer than
    the dataset's scene records and mean what they mean now.

    Returns:
        Scores by the setting's name.
    """
    places = {setting.name: place_of(folder, setting) for setting in settings}
    if all(_is_newer(place / "scores.json", model / WEIGHTS) for place in places.values()):
        return {name: _scores_in(place, data, split, f"{model.name} {name}") for name, place in places.items()}
    reader = DatasetReader(data)
    images = reader.images(split)
    estimators = {setting.name: load_estimator(model, setting.config) for setting in settings}
    first = next(iter(estimators.values()))
    require_known(first, reader, images)
    found: dict[str, list[PoseEstimate]] = {name: [] for name in estimators}
    for start in range(0, len(images), _IMAGES_AT_ONCE):
        group = list(read_images(first, reader, images[start : start + _IMAGES_AT_ONCE]))
        for name, estimator in estimators.items():
            found[name] += estimator.estimate_all(group)
    for name, estimates in found.items():
        predictions.write(places[name] / "predictions.csv", estimates)
    return {name: _scored(place, data, split, f"{model.name} {name}") for name, place in places.items()}


def place_of(folder: Path, setting: Setting) -> Path:
    """Return the folder, in that of a model and a dataset, that keeps what a setting predicted and its scores."""
    return folder / setting.name.replace(" + ", "-")


def _scores_in(place: Path, data: Path, split: str, method: str) -> Scores:
    """Return the scores in a folder; regenerated of its predictions where they are of another format or older data."""
    records = data / "scenes"  # a record that is written there changes the folder's time
    if not records.is_dir() or _is_newer(place / "scores.json", records):
        with suppress(EvaluationError):
            return read_scores(place)
    return _scored(place, data, split, method)


def _scored(place: Path, data: Path, split: str, method: str) -> Scores:
    scores = evaluate(place / "predictions.csv", data, split, method=method)
    write_scores(scores, place)
    return scores


def _is_newer(file: Path, than: Path) -> bool:
    return file.is_file() and file.stat().st_mtime > than.stat().st_mtime


def class_summary(scores: Scores, class_name: str) -> Summary:
    """Return the metrics of one class."""
    return next(item for item in scores.groups["class"] if item.label == class_name)


def rows(scores: Scores, method: str, setting: str, class_name: str) -> list[dict[str, Any]]:
    """Return the fractions of a class as rows of a result file, with 95 % intervals over scenes."""
    common = {
        "method": method,
        "setting": setting,
        "data": scores.dataset["recipe"],
        "split": scores.dataset["split"],
        "class": class_name,
    }
    summary = class_summary(scores, class_name)
    counted = pass_values(scores.table.select(scores.table.class_name == class_name))
    found = {
        metric: (summary.metrics[metric], *summary.intervals[metric], int((~np.isnan(counted[metric])).sum()))
        for metric in FRACTIONS
        if metric in summary.intervals
    }
    if summary.dockable_count and docking_in_range(scores)[-1]:
        found["dock_0mm_2_7m"] = docking_in_range(scores)
    return [
        {
            "name": f"{method}, {setting}, {common['data']} {common['split']}: {metric}",
            **common,
            "metric": metric,
            "value": round(value, 5),
            "interval": [round(low, 5), round(high, 5)],
            "n": count,
        }
        for metric, (value, low, high, count) in found.items()
    ]


def bound_rows(covered: Sequence[dict[str, Any]], scores: Scores, method: str, setting: str) -> list[dict[str, Any]]:
    """Return how often the stated bound holds, by distance, as rows of a result file."""
    place = {"data": scores.dataset["recipe"], "split": scores.dataset["split"]}
    return [
        {
            "name": f"{method}, {setting}, {place['data']} {place['split']}: bound holds, {row['label']}",
            "method": method,
            "setting": setting,
            **place,
            "metric": f"bound holds, {row['label']}",
            **{key: row[key] for key in ("value", "interval", "n")},
        }
        for row in covered
    ]


def docking_in_range(scores: Scores) -> tuple:
    """Return fraction that docks, 95 % interval and number of the pallets requested 2 to 7 m away."""
    table, (low, high) = scores.table, DOCKING_RANGE
    near = table.select(table.dockable & (table.distance >= low) & (table.distance < high))
    docked = near.docks().astype(float)
    if not len(near):
        return float("nan"), float("nan"), float("nan"), 0
    interval = fraction_interval(docked, near.scene_id, 1000, np.random.default_rng(0))
    return float(docked.mean()), *interval, len(near)
