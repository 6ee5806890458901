"""How well detectors find the objects of a dataset: average precision, precision by recall, confusion of classes."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.benchmark.entrants.entrant import ORACLE
from warehouse_sim.benchmark.kept import folder_for, is_kept, keep, weights_digest
from warehouse_sim.benchmark.rows.row import Row, Table
from warehouse_sim.benchmark.rows.scores import mean_row
from warehouse_sim.benchmark.scored import Opened
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.results.detections import FoundObject, read_results, write_results
from warehouse_sim.dataset.results.precision_recall import match, precision_recall
from warehouse_sim.estimators.predict import detect
from warehouse_sim.evaluation.detection.scores import (
    Evaluated,
    Seen,
    edges_of,
    model_classes,
    precision_intervals,
    seen_by_class,
    wanted_in,
)
from warehouse_sim.evaluation.intervals import wilson
from warehouse_sim.geometry.boxes import box_ious
from warehouse_sim.output import make_folder

_LEAST_OVERLAP, _LEAST_SCORE = 0.5, 0.5
_AP_RESAMPLES = 200
_RECALLS = tuple(round(0.1 * k, 1) for k in range(1, 11))
_FOUND, _NOTHING, _SOMETHING, _MISSED = "what was found", "nothing", "something", "missed"


def found_by(name: str, opened: Opened, out: Path, overwrite: bool = False) -> list[FoundObject]:
    """Return what a detector finds in the images of a dataset, kept as a file of COCO's results.

    Args:
        name: ``gt``, or detectors and segmenters by name, run folder or file, joined by +.
        opened: The dataset.
        out: Folder of the benchmark.
        overwrite: Detect again, whatever is kept.

    Raises:
        TrainingError: There are no bundled weights of that name.
        UnknownNameError: There is no such detector.
    """
    reader = opened.reader
    if name == ORACLE:
        return [item for image in reader.images(opened.split) for item in _labelled(reader, image)]
    weights = {part: weights_digest(part) for part in name.split("+")}
    inputs = {"kind": "detector", "names": list(weights), "weights_sha256": weights, "data": reader.digest}
    place = folder_for(out / "detections" / opened.made.root.resolve().name, name.rpartition("/")[2], inputs)
    if overwrite or not is_kept(place, inputs):
        found, _ = detect(name, opened.made.root, opened.split)
        make_folder(place)
        write_results(place / "detections.json", found, reader)
        keep(place, inputs)
    return read_results(place / "detections.json", reader, opened.split)


def detection_rows(name: str, condition: str, found: Sequence[FoundObject], opened: Opened) -> Iterator[Row]:
    """Yield the rows of one detector on one dataset; trainings is 1 for all but the ground truth.

    Args:
        name: The detector.
        condition: Name of the dataset in the suite.
        found: Its detections.
        opened: The dataset.
    """
    reader, evaluated = opened.reader, Evaluated()
    images = reader.images(opened.split)
    trainings = int(name != ORACLE)
    for class_name, parts in sorted(seen_by_class(found, reader, images, evaluated).items()):
        if not wanted_in(parts):
            continue
        scenes = len({item.scene_id for item in parts})

        def row(
            table: Table,
            metric: str,
            value: float,
            ends: tuple[float, float],
            group: str = class_name,
            n: int = wanted_in(parts),
            scenes: int = scenes,
        ) -> Row:
            interval = round(min(ends[0], value), 5), round(max(ends[1], value), 5)
            return Row(table, name, condition, group, metric, round(value, 5), interval, n, scenes, trainings)

        for metric, (value, low, high) in precision_intervals(parts, _AP_RESAMPLES, np.random.default_rng(0)).items():
            # With one scene, or none in uncertainty, a bootstrap has no width.
            one, other = wilson(value, wanted_in(parts))
            yield row("detection", f"ap_{metric}", value, (min(low, one), max(high, other)))
        for recall, value, ends in _precision_by_recall(parts):
            yield row("precision", f"at_recall_{round(100 * recall)}", value, ends)
    yield from _confusion_rows(name, condition, found, opened, evaluated, trainings)


def _labelled(reader: DatasetReader, image: ImageRecord) -> Iterator[FoundObject]:
    for item in image.targets:
        if item.pixels_visible > 0:
            mask, class_name = reader.mask_visible(image, item.gt_index), reader.objects[item.obj_id].class_name
            yield FoundObject(image.scene_id, image.image_id, 1.0, class_name, item.obj_id, mask=mask)


def _precision_by_recall(parts: Sequence[Seen]) -> Iterator[tuple[float, float, tuple[float, float]]]:
    """Yield recall, the best precision at it or beyond, 0 where it is not reached, and a 95 % interval over scenes."""
    matches = [match(item.scores, item.boxes, item.wanted, _LEAST_OVERLAP) for item in parts]
    scenes = sorted({item.scene_id for item in parts})
    of_scene = [[m for m, item in zip(matches, parts, strict=True) if item.scene_id == scene] for scene in scenes]
    picks = np.random.default_rng(0).integers(len(scenes), size=(_AP_RESAMPLES, len(scenes)))
    sampled = np.stack([_read_at([m for number in row for m in of_scene[number]]) for row in picks])
    whole, wanted = _read_at(matches), wanted_in(parts)
    for number, recall in enumerate(_RECALLS):
        low, high = np.percentile(sampled[:, number], [2.5, 97.5])
        one, other = wilson(float(whole[number]), max(round(recall * wanted), 1))
        yield recall, float(whole[number]), (min(float(low), one), max(float(high), other))


def _read_at(matches: list) -> Float[np.ndarray, " r"]:
    precision, recall, _ = precision_recall(matches)
    best = np.append(np.maximum.accumulate(precision[::-1])[::-1], 0.0)
    # A recall of 1 - 1e-16 is one.
    return best[np.minimum(np.searchsorted(recall, np.array(_RECALLS) - 1e-9, side="left"), len(precision))]


def _confusion_rows(
    name: str,
    condition: str,
    found: Sequence[FoundObject],
    opened: Opened,
    evaluated: Evaluated,
    trainings: int,
) -> Iterator[Row]:
    """Yield as what the objects of each class were found, and what fraction of the detections is on nothing."""
    pairs = [
        pair
        for image in opened.reader.images(opened.split)
        for pair in _confusions(image, found, opened.reader, evaluated)
    ]
    for true in sorted({true for true, _, _ in pairs}):
        mine = [(label, scene) for of, label, scene in pairs if of == true]
        scene_id = np.array([scene for _, scene in mine])
        labels = {_NOTHING} if true == _FOUND else {label for label, _ in mine} | {_MISSED}
        for label in sorted(labels):
            values = np.array([one == label for one, _ in mine], dtype=float)
            yield mean_row(("confusion", name, condition, true, f"as {label}"), values, scene_id, trainings)


def _confusions(
    image: ImageRecord, found: Sequence[FoundObject], reader: DatasetReader, evaluated: Evaluated
) -> Iterator[tuple[str, str, int]]:
    """Yield true class, class that it was found as, and scene: the surest detection first, whatever its class."""
    mine = [
        item
        for item in found
        if (item.scene_id, item.image_id) == (image.scene_id, image.image_id) and item.score >= _LEAST_SCORE
    ]
    mine.sort(key=lambda item: -item.score)
    targets = [item for item in image.targets if item.pixels_visible > 0]
    names = model_classes(reader)
    boxes = np.array([edges_of(item) for item in mine], dtype=float).reshape(-1, 4)
    gt = np.array([item.box_visible_xyxy for item in targets], dtype=float).reshape(-1, 4)
    gt[:, 2:] += 1.0
    overlap, as_what = box_ious(boxes, gt), dict[int, str]()
    for row, item in enumerate(mine):
        free = [k for k in range(len(targets)) if k not in as_what and overlap[row, k] >= _LEAST_OVERLAP]
        label = item.class_name or names.get(item.model or 0, "unknown")
        if free:
            as_what[free[int(overlap[row, free].argmax())]] = label
        on_something = bool((overlap[row] >= _LEAST_OVERLAP).any())
        yield _FOUND, _SOMETHING if on_something else _NOTHING, image.scene_id
    for number, target in enumerate(targets):
        if evaluated.takes(target):
            yield reader.objects[target.obj_id].class_name, as_what.get(number, _MISSED), image.scene_id
