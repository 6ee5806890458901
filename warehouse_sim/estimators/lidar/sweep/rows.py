"""The floor of a sweep, and the sweeps of a dataset as rows of arrays: range, height above the floor, boxes."""

from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.estimators.images.rows import MOST_LABELS
from warehouse_sim.estimators.lidar.projection import read_sweep
from warehouse_sim.estimators.lidar.sweep.range_image import RangeImage, SweepGrid, id_boxes, range_image
from warehouse_sim.estimators.lidar.sweep.settings import RangeImageConfig
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.split import load_rows, reports_reading, split_images
from warehouse_sim.learning.settings import Progress
from warehouse_sim.schema import LidarScan

_TRIED = 3000
"""Points that the search looks at."""
_ROUNDS = 200
_MOST_SLOPE = 0.1
"""A steeper plane (rad, nearly) against the LiDAR's own horizon is no floor."""
_FARTHEST = 20.0
_LEAST_FRACTION = 0.05
Plane = Float[np.ndarray, " 3"]
"""Slopes a, b and height c (m) of z = a x + b y + c in the LiDAR frame."""


def floor_of(points: Float[np.ndarray, "n 3"], rng: np.random.Generator) -> Plane | None:
    """Return the plane of most points among those that nearly lie level and that nothing much lies under.

    Sampled triples (RANSAC, Fischler and Bolles 1981), then least squares. None where no floor is seen.

    Args:
        points: LiDAR frame (m), z about upwards.
        rng: Source of randomness.
    """
    points = np.asarray(points, dtype=float)
    near = points[(np.hypot(points[:, 0], points[:, 1]) < _FARTHEST) & (points[:, 2] < 0.0)]
    if len(near) < 100:
        return None
    tried = near[rng.choice(len(near), min(len(near), _TRIED), replace=False)]
    tolerance = 0.02 + 0.003 * np.linalg.norm(tried, axis=1)
    best, most = None, _LEAST_FRACTION
    for _ in range(_ROUNDS):
        three = tried[rng.choice(len(tried), 3, replace=False)]
        try:
            plane = np.linalg.solve(np.column_stack([three[:, :2], np.ones(3)]), three[:, 2])
        except np.linalg.LinAlgError:
            continue
        above = above_floor(tried, plane)
        on = float((np.abs(above) <= tolerance).mean())
        if np.abs(plane[:2]).max() <= _MOST_SLOPE and on > most and (above < -3.0 * tolerance).mean() < 0.02:
            best, most = plane, on
    return None if best is None else _fitted(near, best)


def above_floor(points: Float[np.ndarray, "n 3"], plane: Plane) -> Float[np.ndarray, " n"]:
    """Return the distance (m) of points (LiDAR frame) to a plane, positive above it."""
    height = points[:, 2] - points[:, :2] @ plane[:2] - plane[2]
    return np.asarray(height / np.sqrt(1.0 + plane[:2] @ plane[:2]))


def up_of(plane: Plane) -> Float[np.ndarray, " 3"]:
    """Return the unit normal of a plane that points up (LiDAR frame)."""
    normal = np.array([-plane[0], -plane[1], 1.0])
    return normal / np.linalg.norm(normal)


def _fitted(points: Float[np.ndarray, "n 3"], plane: Plane) -> Plane:
    for _ in range(3):
        on = np.abs(above_floor(points, plane)) <= 0.02 + 0.003 * np.linalg.norm(points, axis=1)
        flat = points[on]
        plane = np.linalg.lstsq(np.column_stack([flat[:, :2], np.ones(len(flat))]), flat[:, 2], rcond=None)[0]
    return np.asarray(plane)


SWEEP_LABEL = ("left", "top", "right", "bottom", "obj_id", "fraction", "points", "instance_id")
"""Columns of a label: edges (px), object, fraction of its box that is seen (1 of a whole turn), its points, its id."""
UNKNOWN_MM = -32_768
"""Height of a pixel where no floor was found."""
_FORMAT = 1
"""To be raised when the arrays change."""


def floor_in(points: np.ndarray) -> Plane | None:
    """Return the floor of a sweep (LiDAR frame); the same sweep has the same floor, None where it shows none."""
    return floor_of(points, np.random.default_rng(0))


def two_planes(image: RangeImage, points: np.ndarray, floor: Plane | None) -> Float32[np.ndarray, "2 h w"]:
    """Return range (m, 0 = no reading) and height above the floor (m, NaN = unknown) as a network reads them."""
    height = np.full(len(points), np.nan) if floor is None else above_floor(points, floor)
    return np.stack([image.range, image.of_points(height, np.nan)])


def sweep_rows(reader: DatasetReader, image: ImageRecord, config: RangeImageConfig) -> Arrays:
    """Return one row of each array.

    ``range_mm`` (1 h w) uint16, 0 = no reading; ``height_mm`` (1 h w) int16, ``UNKNOWN_MM`` if unknown;
    ``obj_id`` (1 h w) uint16, that of the object with a label which a pixel shows, 0 = none;
    ``labels`` (1 m 8) a row an object as ``SWEEP_LABEL`` names it, those of most points, NaN where there is none.
    """
    scan = read_sweep(reader, image).reading
    points = scan.points.astype(float)
    seen = range_image(points, SweepGrid(config))
    metres, height = two_planes(seen, points, floor_in(points))
    objects = objects_about(reader, image)
    ids, of = np.unique(scan.instance_ids, return_inverse=True)
    obj_id = np.array([objects.get(int(number), 0) for number in ids], dtype=float)[of]
    steps = np.clip(np.rint(np.nan_to_num(height, nan=0.0) * 1000.0), -32_767, 32_767)
    return {
        "labels": sweep_labels(seen, scan, objects)[None],
        "range_mm": np.clip(np.rint(metres * 1000.0), 0, 65_535).astype(np.uint16)[None],
        "height_mm": np.where(np.isnan(height), UNKNOWN_MM, steps).astype(np.int16)[None],
        "obj_id": seen.of_points(obj_id).astype(np.uint16)[None],
        "number": np.array([[image.scene_id, image.image_id]], dtype=np.int32),
    }


def objects_about(reader: DatasetReader, image: ImageRecord) -> dict[int, int]:
    """Return the obj_id of each instance id about the sensor, in the camera's view or not, of objects with labels."""
    if reader.manifest is None:
        return {target.instance_id: target.obj_id for target in image.targets if target.instance_id}
    record = read_scene_record(reader.root, image.scene_id)
    return {item.instance_id: item.obj_id for item in record.objects if item.obj_id in reader.objects}


def sweep_labels(seen: RangeImage, scan: LidarScan, objects: dict[int, int]) -> Float32[np.ndarray, "m 8"]:
    """Return the labels of the objects that a sweep shows."""
    labels = np.full((MOST_LABELS, len(SWEEP_LABEL)), np.nan, dtype=np.float32)
    ids, counts = np.unique(scan.instance_ids, return_counts=True)
    known = [(int(count), int(number)) for number, count in zip(ids, counts, strict=True) if int(number) in objects]
    known = sorted(known, key=lambda item: (-item[0], item[1]))[:MOST_LABELS]
    numbers = np.array([number for _, number in known], dtype=np.int64)
    row = 0
    for (count, number), box in zip(known, id_boxes(seen, scan.instance_ids, numbers), strict=True):
        if np.isfinite(box).all():
            labels[row] = *box, objects[number], 1.0, count, number
            row += 1
    return labels


def load_sweeps(
    reader: DatasetReader,
    split: str,
    config: RangeImageConfig,
    workers: int,
    cache: Path | None,
    progress: Progress | None = None,
) -> Arrays | None:
    """Return the arrays of ``sweep_rows`` for all images of a split; None if it has none.

    Arguments are those of ``load_rows``; ``config`` says which directions are seen.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
        DatasetError: There are no sweeps.
    """
    settings, report = ["sweep", _FORMAT, split, asdict(config)], reports_reading(progress, split, reader)
    images, read = split_images(reader, split), partial(sweep_rows, reader, config=config)
    return load_rows(reader, split, images, read, settings, "sweeps", workers, cache, report, f"{split}-sweep")
