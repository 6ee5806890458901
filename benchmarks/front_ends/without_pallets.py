"""Count images without any pallet in which a detector sees one, at the score that finds 80 of 100 pallets elsewhere.

python -m benchmarks.front_ends.without_pallets [--folder out/without_pallets]

Scenes are of no training. Rows go to benchmarks/results/without_pallets.json.
"""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from jaxtyping import Float

from benchmarks.speed.result import RESULTS, rounded, write_result
from trainings.data import TARGETS, made
from trainings.warehouses import ON_REQUEST, Part
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.detections import open_front_end
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.images.faces import FACE, face_labels
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.estimators.images.rows import image_labels
from warehouse_sim.estimators.segmenters.segnet.estimator import detection_edges
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.geometry.boxes import box_ious

FOLDER = Path("out/without_pallets")
DETECTORS = {"detector-rgb-warehouses": (FACE, "pallet")}
"""What each is requested to find."""
RECALL = 0.8
_SEED, _WITH, _WITHOUT, _VIEWS = 515_152, 6, 12, 8
"""Seed of the scenes, how many of them have pallets and how many of each kind have none, and images of each."""
_LEAST_SCORE, _OVERLAP = 0.02, 0.5
_VISIBLE, _HEIGHT_PX = 0.5, 16.0
"""What is to be found: half of it visible, so many pixels high."""
_RESAMPLES = 1000


def data(kind: str) -> Part:
    """Return the scenes of a kind of parts."""
    scenes = _WITHOUT if kind in ON_REQUEST else _WITH
    return Part(kind, _SEED, kind, scenes, _VIEWS, SplitConfig(0.0, 0.0, 1.0), targets=TARGETS)


def main(folder: Path = FOLDER, workers: int = os.cpu_count() or 1) -> None:
    """Detect, count, print and store.

    Args:
        folder: Where data are kept.
        workers: Processes that generate.
    """
    readers = {kind: DatasetReader(made(data(kind), folder, workers)) for kind in ("pallets_anywhere", *ON_REQUEST)}
    rows = [row for name, classes in DETECTORS.items() for row in _rows(name, classes, readers)]
    for row in rows:
        print(row)
    write_result(RESULTS / "without_pallets.json", "python -m benchmarks.front_ends.without_pallets", rounded(rows))


def _rows(name: str, classes: Sequence[str], readers: dict[str, DatasetReader]) -> Iterator[dict[str, Any]]:
    seen = {kind: list(_found(name, reader)) for kind, reader in readers.items()}
    for class_name in classes:
        reader = readers["pallets_anywhere"]
        score, wanted = score_at(RECALL, class_name, reader, seen["pallets_anywhere"])
        for kind in ON_REQUEST:
            best = [max((item.score for item in of(class_name, found)), default=0.0) for _, found in seen[kind]]
            wrong = np.array(best) >= score
            scenes = np.array([image.scene_id for image, _ in seen[kind]])
            interval = fraction_interval(wrong.astype(float), scenes, _RESAMPLES, np.random.default_rng(0))
            yield {
                "name": f"{name}, {class_name}: {kind}",
                "detector": name,
                "class": class_name,
                "kind": kind,
                "score": score,
                "found_of": wanted,
                "value": float(wrong.mean()),
                "interval": list(interval),
                "n": len(wrong),
            }


def _found(name: str, reader: DatasetReader) -> Iterator[tuple[ImageRecord, list[Detection]]]:
    detect = open_front_end(name)
    detect.leave_out_below(_LEAST_SCORE)
    for image in reader.images("test"):
        yield image, list(detect(RgbdImage.from_dataset(reader, image, ())))


def of(class_name: str, found: Sequence[Detection]) -> list[Detection]:
    """Return the detections of a class, the best first."""
    return sorted((item for item in found if item.class_name == class_name), key=lambda item: -item.score)


def score_at(
    recall: float, class_name: str, reader: DatasetReader, seen: Sequence[tuple[ImageRecord, list[Detection]]]
) -> tuple[float, int]:
    """Return the score from which on so many of what is labelled are found, 0 where they never are; and the number."""
    scores = list[float]()
    for image, found in seen:
        labels = labelled(class_name, reader, image)
        scores += matched_scores(labels, of(class_name, found))
    needed = int(np.ceil(recall * len(scores)))
    return sorted(scores, reverse=True)[needed - 1], len(scores)


def matched_scores(labels: Float[np.ndarray, "n 4"], found: Sequence[Detection]) -> list[float]:
    """Return the score of the detection of each label, 0 where none is; each takes the free label it is most alike."""
    scores = np.zeros(len(labels))
    for item in found if len(labels) else ():
        alike = box_ious(np.array([detection_edges(item)]), labels)[0] * (scores == 0.0)
        if alike.max() >= _OVERLAP:
            scores[alike.argmax()] = item.score
    return scores.tolist()


def labelled(class_name: str, reader: DatasetReader, image: ImageRecord) -> Float[np.ndarray, "n 4"]:
    """Return the edges (px) of what is to be found."""
    size_wh = image.camera.width, image.camera.height
    box = Letterbox.fit(size_wh, size_wh)
    if class_name == FACE:
        rows = face_labels(reader, image, box)
    else:
        targets = tuple(item for item in image.targets if item.info(reader.objects).class_name == class_name)
        rows = image_labels(targets, box, np.zeros((0, 8)))
        rows = rows[~np.isnan(rows[:, 0])]
    return np.asarray(rows[(rows[:, 5] >= _VISIBLE) & (rows[:, 6] >= _HEIGHT_PX), :4])


if __name__ == "__main__":
    tyro.cli(main)
