"""Score a detector of sweeps by boxes of its range image, on pallets all around the LiDAR, seen by a camera or not."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.front_ends.data import TEST_DISTANCE, TEST_INDUSTRIAL
from trainings.data import Data
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.estimators.detectors.estimator import DetectConfig
from warehouse_sim.estimators.lidar.projection import read_sweep
from warehouse_sim.estimators.lidar.sweep.estimator import TrainedSweepDetector
from warehouse_sim.estimators.lidar.sweep.range_image import range_image, ring_overlaps
from warehouse_sim.estimators.lidar.sweep.rows import objects_about, sweep_labels
from warehouse_sim.evaluation.detection.scores import Seen, precision_intervals, wanted_in
from warehouse_sim.geometry.pose import invert
from warehouse_sim.resources import model_dir

LEAST_POINTS = 30
"""Pallets with fewer are not requested; what is found on them is neither right nor wrong."""
_EVERY = DetectConfig(min_score=0.01, threads=1)
"""Average precision requires all that is found, however unsure."""


@dataclass(frozen=True)
class SweepQuestion:
    """What is scored on what."""

    name: str
    """As it is called in tables."""
    data: Data
    distance: tuple[float, float] = (0.0, 1e9)
    """From the LiDAR to the pallet (m)."""
    detector: str = "detector-sweep"


SWEEP_QUESTIONS = (
    SweepQuestion("detector-sweep, industrial", TEST_INDUSTRIAL),
    *(
        SweepQuestion(f"detector-sweep, distance_study, {low:g}-{high:g} m", TEST_DISTANCE, (low, high))
        for low, high in ((0.0, 7.0), (7.0, 15.0), (15.0, 25.0), (25.0, 35.0))
    ),
)


def answer_in_sweeps(question: SweepQuestion, run: Path | str, root: Path, resamples: int) -> list[dict[str, Any]]:
    """Return a row for pallets, scores with 95 % intervals over scenes; none where there is no pallet to be found.

    Args:
        question: What is evaluated.
        run: Run folder, or bundled name.
        root: Dataset with sweeps; its split test is looked at.
        resamples: Bootstrap resamples.
    """
    torch.set_num_threads(1)
    reader, detector = DatasetReader(root), TrainedSweepDetector(model_dir(run), _EVERY)
    seconds = list[float]()
    parts = [_seen(reader, image, detector, question.distance, seconds) for image in reader.images("test")]
    if not wanted_in(parts):
        return []
    row: dict[str, Any] = {
        "name": f"{question.name}: pallet",
        "stages": [question.detector],
        "data": root.name,
        "n": wanted_in(parts),
        "least_points": LEAST_POINTS,
    }
    for metric, (value, low, high) in precision_intervals(parts, resamples, np.random.default_rng(0)).items():
        row[metric] = {"value": value, "interval": [low, high]}
    row["value"], row["interval"] = row["box_50"]["value"], row["box_50"]["interval"]
    row["median_ms"] = 1000 * float(np.median(seconds))
    return [row]


def _seen(
    reader: DatasetReader,
    image: ImageRecord,
    detector: TrainedSweepDetector,
    distance: tuple[float, float],
    seconds: list[float],
) -> Seen:
    mounted = read_sweep(reader, image)
    points = mounted.reading.points.astype(float)
    started = time.perf_counter()
    found, _ = detector.find(points)
    seconds.append(time.perf_counter() - started)
    labels = sweep_labels(range_image(points, detector.grid), mounted.reading, objects_about(reader, image))
    labels = labels[np.isfinite(labels[:, 0])]
    labels = labels[[reader.objects[int(number)].class_name == "pallet" for number in labels[:, 4]]]
    T_lidar_world = invert(image.T_world_camera @ mounted.T_camera_sensor)
    record = read_scene_record(reader.root, image.scene_id)
    places = {item.instance_id: (T_lidar_world @ item.T_world_object)[:3, 3] for item in record.objects}
    far = np.array([np.linalg.norm(places[int(number)]) for number in labels[:, 7]])
    wanted = (labels[:, 6] >= LEAST_POINTS) & (far >= distance[0]) & (far < distance[1])
    boxes = np.array([item.box for item in found]).reshape(-1, 4)
    overlap, covered = ring_overlaps(boxes, labels[:, :4].astype(float), detector.grid.config.columns)
    return Seen(image.scene_id, np.array([item.score for item in found]), wanted, np.where(wanted, overlap, covered))
