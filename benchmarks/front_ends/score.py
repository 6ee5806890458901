"""Score the front ends on scenes that none was trained on; writes benchmarks/results/front_ends.json.

python -m benchmarks.front_ends.score [--runs out/front_ends/runs] [--only detector-depth] [--images N]

Detectors by boxes, segmenters by masks in the boxes of a detector and in the true ones; misses count. Without a run
folder the bundled weights are scored.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.front_ends.data import SCORED_ON, TEST_DISTANCE, TEST_INDUSTRIAL
from benchmarks.front_ends.sweeps import SWEEP_QUESTIONS, answer_in_sweeps
from benchmarks.result import RESULTS, beside_stored, rounded, write_result
from trainings.data import FRONT_ENDS, Data, made
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import FoundObject, read_results, write_results
from warehouse_sim.estimators.predict import detect
from warehouse_sim.evaluation.detection.scores import (
    Evaluated,
    precision_intervals,
    score_detections,
    seen_by_class,
    wanted_in,
)

PALLETS = ("pallet",)
RANGES = ((0.0, 7.0), (7.0, 15.0), (15.0, 25.0), (25.0, 35.0))
"""Distances (m) of the dissertation's tables."""
_RESAMPLES = 500
GT = "gt-boxes"
"""A stage: the boxes of the labels."""


@dataclass(frozen=True)
class Question:
    """What is scored on what."""

    name: str
    """As it is called in tables."""
    stages: tuple[str, ...]
    """Front ends, each working on what the one before found."""
    data: Data
    evaluated: Evaluated
    classes: tuple[str, ...] = PALLETS


SEEN = Evaluated(0.1, 8.0)
WELL_SEEN = Evaluated(0.25, 8.0)
_DETECTORS = ("detector-depth", "detector-rgb", "detector-rgbd", "detector-lidar")
QUESTIONS = (
    *(Question(f"{name}, industrial", (name,), TEST_INDUSTRIAL, SEEN) for name in _DETECTORS),
    *(
        Question(
            f"detector-rgb, {data.recipe}",
            ("detector-rgb",),
            data,
            SEEN,
            ("forklift", "person", *PALLETS[: data != TEST_INDUSTRIAL]),
        )
        for data in SCORED_ON
    ),
    *(
        Question(f"{name}, {data.recipe}", (name,), data, SEEN)
        for name in ("detector-depth", "detector-rgbd")
        for data in SCORED_ON[1:]
    ),
    *(
        Question(f"detector-lidar, distance_study, {low:g}-{high:g} m", ("detector-lidar",), TEST_DISTANCE, evaluated)
        for low, high in RANGES
        for evaluated in [Evaluated(0.1, 8.0, (low, high))]
    ),
    *(
        Question(f"{detector}+{name}, industrial", (detector, name), TEST_INDUSTRIAL, WELL_SEEN)
        for detector, name in (
            *(("detector-depth", "segmenter-depth"), ("detector-rgb", "segmenter-rgb")),
            *(("detector-rgb", "keypoints-rgb"), (GT, "segmenter-depth")),
        )
    ),
)


def main(
    folder: Path = FRONT_ENDS, runs: Path | None = None, only: tuple[str, ...] = (), workers: int = os.cpu_count() or 1
) -> None:
    """Score all that is trained.

    Args:
        folder: Where data are kept, and what was found.
        runs: Run folders by method, by default those in FOLDER; bundled weights where there is none.
        only: Questions in whose names one of these is; rows of others in the result file stay.
        workers: Processes that generate.
    """
    rows = list[dict[str, Any]]()
    for question in QUESTIONS:
        if only and not any(text in question.name for text in only):
            continue
        stages = [_place(name, runs or folder / "runs") for name in question.stages]
        if None in stages:
            print(f"{question.name}: not trained yet")
            continue
        root = made(question.data, folder, workers)
        rows += answer(question, [str(stage) for stage in stages], root, folder / "found")
        print(rows[-1] if rows else f"{question.name}: nothing to be found")
    for evaluated in SWEEP_QUESTIONS:
        if only and not any(text in evaluated.name for text in only):
            continue
        if place := _place(evaluated.detector, runs or folder / "runs"):
            rows += answer_in_sweeps(evaluated, place, made(evaluated.data, folder, workers), _RESAMPLES)
            print(rows[-1])
    file = RESULTS / "front_ends.json"
    seeds = {item.folder_name: {"recipe": item.recipe, "seed": item.seed} for item in SCORED_ON}
    write_result(file, "python -m benchmarks.front_ends.score", beside_stored(file, rounded(rows)), data=seeds)


def answer(question: Question, stages: Sequence[str], root: Path, kept: Path) -> list[dict[str, Any]]:
    """Return a row for each class: scores with 95 % intervals over scenes, and the time an image takes."""
    reader = DatasetReader(root)
    file = kept / root.name / ("+".join(question.stages) + ".json")
    images, seconds = reader.images("test"), list[float]()
    if not _is_newer(file, stages):
        given = [str(gt_boxes(reader, kept / root.name / "gt.json")) if x == GT else x for x in stages]
        found, seconds = detect("+".join(given), root, "test")
        file.parent.mkdir(parents=True, exist_ok=True)
        write_results(file, found, reader)
    found = read_results(file, reader, "test")
    scores = {item.class_name: item for item in score_detections(found, reader, images, question.evaluated)}
    rows = []
    for name, parts in seen_by_class(found, reader, images, question.evaluated).items():
        if name not in question.classes or not wanted_in(parts):
            continue
        row: dict[str, Any] = {
            "name": f"{question.name}: {name}",
            "stages": list(question.stages),
            "data": root.name,
            "n": wanted_in(parts),
        }
        for metric, (value, low, high) in precision_intervals(parts, _RESAMPLES, np.random.default_rng(0)).items():
            row[metric] = {"value": value, "interval": [low, high]}
        headline = row["mask_50" if "mask_50" in row else "box_50"]
        row["value"], row["interval"] = headline["value"], headline["interval"]
        row["precision"], row["panoptic_quality"] = dict(scores[name].precision), scores[name].panoptic_quality
        if seconds:
            row["median_ms"] = 1000 * float(np.median(seconds))
        rows.append(row)
    return rows


def gt_boxes(reader: DatasetReader, path: Path) -> Path:
    """Write the labels' boxes as a file of detections, for front ends that look into boxes; return the file."""
    found = [
        FoundObject(
            image.scene_id,
            image.image_id,
            1.0,
            reader.objects[target.obj_id].class_name,
            edges=(left, top, right + 1.0, bottom + 1.0),
        )
        for image in reader.images("test")
        for target in image.targets
        if target.pixels_visible
        for left, top, right, bottom in [target.box_visible_xyxy]
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    write_results(path, found, reader)
    return path


def _is_newer(file: Path, stages: Sequence[str]) -> bool:
    weights = [Path(stage) / "weights.safetensors" for stage in stages]
    return file.is_file() and all(item.stat().st_mtime < file.stat().st_mtime for item in weights if item.is_file())


def _place(name: str, runs: Path) -> Path | str | None:
    """Return a run folder, a bundled name, or None where there is neither."""
    from warehouse_sim.resources import model_names

    if (runs / name / "weights.safetensors").is_file():
        return runs / name
    return name if name in model_names() or name == GT else None


if __name__ == "__main__":
    tyro.cli(main)
