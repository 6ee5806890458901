"""Estimators away from what they were trained on: sensors, mountings, layouts, pallets whose class nobody names.

    python -m benchmarks.estimators.shifted rectangle-fit icp-multistart densefusion-depth --write

Sets are made under out/estimators/data/shifted_* where they are missing; benchmarks/estimators/shifts.py says what each
is. Docking is that of ``evaluate``, with the ground-truth masks.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import tyro

from benchmarks.estimators.data import FOLDER
from benchmarks.estimators.shifts import SEED, SHIFTS, Shift, made
from benchmarks.estimators.slices import docking_rows
from benchmarks.estimators.stress import predict, scored
from benchmarks.estimators.ways import open_way
from benchmarks.result import RESULTS, write_result
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.predict import read_images
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.schema import PoseEstimate

_Key = tuple[int, int, int | None]


def estimates_of(
    estimator: PoseEstimator, images: Sequence[RgbdImage], reader: DatasetReader, shift: Shift
) -> list[PoseEstimate]:
    """Return what an estimator says of a set's images.

    Where detections have no name, the objects of the set are the candidates: an estimator that was shown them decides
    itself, as does one that goes by verification, which knows the candidates; of another trained one each
    candidate is requested, and the highest score counts.
    """
    if not shift.candidates or estimator.objects is None:
        return predict(estimator, images, shift.disturb)
    known = {shape.obj_id for shape in estimator.objects}
    if getattr(estimator, "config", PredictConfig()).refine == "verify":
        may_be = tuple(sorted(known & set(reader.objects)))
        return predict(estimator, [_as_one_of(image, may_be) for image in images], lambda image, rng: image)
    best: dict[_Key, PoseEstimate] = {}
    for obj_id in sorted(known & set(reader.objects)):
        for item in predict(estimator, [_as_if(image, obj_id) for image in images], lambda image, rng: image):
            key = item.scene_id, item.image_id, item.detection
            best[key] = max(best.get(key, item), item, key=lambda one: one.score)
    # Asked five times, an image has no one time.
    return [replace(item, time=-1.0) for item in best.values()]


def rows_of(method: str, shift: Shift, data: Path, place: Path) -> list[dict[str, Any]]:
    """Return the docked fractions of an estimator on a set, as rows of a result file."""
    reader = DatasetReader(data)
    estimator = open_way(method, reader.objects)
    images = list(read_images(estimator, reader, reader.images("test")))
    table = scored(estimates_of(estimator, images, reader, shift), data, place, f"{method}, {shift.name}").table
    return [
        {
            "name": f"{method}, {shift.name}: docked, {row['slice']}, {row['margin_mm']} mm",
            "method": method,
            "set": shift.name,
            **row,
            "metres": list(shift.within),
        }
        for row in docking_rows(table, reader, shift.within, shift.least_visible)
    ]


def main(
    methods: tyro.conf.Positional[tuple[str, ...]],
    folder: Path = FOLDER,
    scenes: int = 8,
    views: int = 6,
    only: tuple[str, ...] = (),
    again: bool = False,
    write: bool = False,
) -> None:
    """Score estimators on every set; what was scored before is read, so that a run that was interrupted goes on.

    Args:
        methods: Bundled models or run folders, perhaps with +verify, or registered estimators that need no training.
        folder: Where data, predictions and scores are kept.
        scenes: Number of scenes of a set; sets that are there stay as they are.
        views: Observations of each scene.
        only: Names of sets; all by default.
        again: Score again, as after a training.
        write: Store the result.
    """
    found, held = [], {}
    for shift in SHIFTS:
        if only and shift.name not in only:
            continue
        data = made(shift, scenes, views, folder)
        held[shift.name] = sum(map(len, DatasetReader(data).splits.values()))
        for method in methods:
            place = folder / "scores" / Path(method).name / data.name
            kept = place / "rows.json"
            if again or not kept.is_file():
                write_json(kept, rows_of(method, shift, data, place))
            rows = read_json(kept)
            found += rows
            for row in rows:
                if row["margin_mm"] == 0:
                    low, high = row["interval"]
                    print(f"{row['name']:80} {row['value']:.3f} [{low:.3f}, {high:.3f}] n {row['n']}", flush=True)
    if write:
        chosen = f" --only {' '.join(map(repr, only))}" if only else ""
        size = f"--scenes {scenes} --views {views}{chosen}"
        command = f"python -m benchmarks.estimators.shifted {' '.join(methods)} {size} --write"
        write_result(RESULTS / "shifted.json", command, found, seed=SEED, scenes=held)


def _as_if(image: RgbdImage, obj_id: int) -> RgbdImage:
    """Return the image with every detection named so."""
    return replace(image, detections=tuple(replace(item, model=obj_id) for item in image.detections))


def _as_one_of(image: RgbdImage, may_be: tuple[int, ...]) -> RgbdImage:
    """Return the image with detections that are one of some objects, nobody says which."""
    return replace(image, detections=tuple(replace(item, model=None, may_be=may_be) for item in image.detections))


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
