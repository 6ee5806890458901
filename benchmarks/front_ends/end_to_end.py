"""Score chains from pixels to poses, beside estimators with ground-truth masks and ground-truth boxes.

python -m benchmarks.front_ends.end_to_end [--write]

Docking is evaluated of all pallets 2 to 7 m away that a truck can take, found or not. A false alarm is an estimate that
lies on no pallet: no true one, however little is seen of it, is within half a metre.
"""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.estimators.score import docking_in_range
from benchmarks.front_ends.data import TEST_DISTANCE, TEST_INDUSTRIAL
from benchmarks.result import RESULTS, beside_stored, rounded, write_result
from trainings.data import FRONT_ENDS, Data, made
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.evaluation import Scores, evaluate
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.schema import PoseEstimate

_NEAR = 0.5
"""An estimate farther than this (m) from every true pallet is a false alarm."""
_OBJECTS = ("epal1",)
"""That stand in the halls; new, grey and damaged ones are of its shape."""


@dataclass(frozen=True)
class Case:
    """One chain or estimator on one dataset."""

    name: str
    estimator: str
    data: Data
    config: PredictConfig


_PLAIN = PredictConfig(objects=_OBJECTS)
_ICP = replace(_PLAIN, selection="consensus", refine="icp")
_VERIFICATION = replace(_PLAIN, selection="consensus", refine="verify")
_GT = "gt"
CASES = (
    Case("ground-truth masks", "densefusion-depth", TEST_INDUSTRIAL, replace(_ICP, detections=_GT)),
    Case("segment-densefusion-depth", "segment-densefusion-depth", TEST_INDUSTRIAL, _ICP),
    Case("ground-truth masks+verify", "densefusion-depth", TEST_INDUSTRIAL, replace(_VERIFICATION, detections=_GT)),
    Case("segment-densefusion-depth+verify", "segment-densefusion-depth", TEST_INDUSTRIAL, _VERIFICATION),
    # Without a network for the pose: what the finding alone is worth.
    Case("rectangle-fit, ground-truth masks", "rectangle-fit", TEST_INDUSTRIAL, replace(_PLAIN, detections=_GT)),
    Case("segment-rectangle-fit", "segment-rectangle-fit", TEST_INDUSTRIAL, _PLAIN),
    Case("detect-depth", "detect-depth", TEST_INDUSTRIAL, _ICP),
    Case("detect-densefusion", "detect-densefusion", TEST_INDUSTRIAL, _ICP),
    Case("detect-keypoints", "detect-keypoints", TEST_INDUSTRIAL, _PLAIN),
    *(
        Case(name, "detect-pointcloud", TEST_DISTANCE, replace(_VERIFICATION, detections=detections))
        for name, detections in (
            ("detect-pointcloud, ground-truth masks", _GT),
            ("detect-pointcloud, ground-truth boxes", "gt-boxes"),
            ("detect-pointcloud", "auto"),
        )
    ),
    Case("lidar-direct, ground-truth masks", "lidar-direct", TEST_DISTANCE, replace(_VERIFICATION, detections=_GT)),
    Case("lidar-direct", "lidar-direct", TEST_DISTANCE, _VERIFICATION),
)
"""Chains with the bundled weights, each beside the same with the ground truth in place of what it finds."""


def main(
    folder: Path = FRONT_ENDS, only: tuple[str, ...] = (), workers: int = os.cpu_count() or 1, write: bool = False
) -> None:
    """Predict, score and print.

    Args:
        folder: Where data are kept, and poses.
        only: Cases in whose names one of these is.
        workers: Processes that generate.
        write: Store what was measured; rows of other cases in the result file stay.
    """
    rows, file = [], RESULTS / "front_end_chains.json"
    for case in CASES:
        if only and not any(text in case.name for text in only):
            continue
        root = made(case.data, folder, workers)
        poses = predict(case.estimator, root, "test", case.config)
        csv = folder / "poses" / f"{case.name.replace(', ', '-').replace(' ', '_')}.csv"
        csv.parent.mkdir(parents=True, exist_ok=True)
        predictions.write(csv, poses)
        rows.append(row(case, root, poses, evaluate(csv, root, "test", method=case.name)))
        print(rows[-1], flush=True)
        if write:
            command = "python -m benchmarks.front_ends.end_to_end --write"
            write_result(file, command, beside_stored(file, rounded(rows)))


def row(case: Case, root: Path, poses: list[PoseEstimate], scores: Scores) -> dict[str, Any]:
    """Return the fractions with ADD under a tenth of the diameter, of all and of those found, docking, false alarms."""
    table = scores.table.select(scores.table.class_name == "pallet")
    docked, low, high, count = docking_in_range(scores)
    right = (table.add < 0.1 * table.diameter).astype(float)
    found = table.prediction >= 0
    rng = np.random.default_rng(0)
    reader = DatasetReader(root)
    images = reader.images("test")
    false = false_alarms(poses, reader)
    of_all = _fraction(right, table.scene_id, rng)
    return {
        "name": case.name,
        "value": of_all["value"],
        "interval": of_all["interval"],
        "data": root.name,
        "docked_2_7m": {"value": docked, "interval": [low, high], "n": count},
        "add_10pct_of_found": _fraction(right[found], table.scene_id[found], rng),
        "false_alarms": {"count": false, "an_image": false / len(images), "of": len(poses)},
        "seconds_an_image": scores.seconds_per_image,
    }


def false_alarms(poses: list[PoseEstimate], reader: DatasetReader) -> int:
    """Return how many estimates lie on no pallet."""
    places: dict[tuple[int, int], np.ndarray] = {}
    for image in reader.images("test"):
        centres = [
            target.T_camera_object[:3, 3]
            for target in image.targets
            if reader.objects[target.obj_id].class_name == "pallet"
        ]
        places[image.scene_id, image.image_id] = np.reshape(centres, (-1, 3))
    count = 0
    for item in poses:
        apart = np.linalg.norm(places[item.scene_id, item.image_id] - item.T_camera_object[:3, 3], axis=1)
        count += not (apart < _NEAR).any() and not item.rejected
    return count


def _fraction(values: np.ndarray, scene_id: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
    if not len(values):
        return {"value": None, "n": 0}
    low, high = fraction_interval(values, scene_id, 1000, rng)
    return {"value": float(values.mean()), "interval": [low, high], "n": len(values)}


if __name__ == "__main__":
    tyro.cli(main)
