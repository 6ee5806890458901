"""Files of detections: COCO's results (one JSON list) as any tool writes them, BOP's variant, YOLO's label files.

A row of COCO's has ``image_id``, ``category_id``, ``bbox`` (x, y, w, h) or ``segmentation``, and ``score``. One of
BOP's has ``scene_id`` beside; ``image_id`` then counts within the scene, and ``category_id`` is an object's number. A
label file of YOLO's is of one image, with a row ``class x y w h score`` for each, as fractions.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.plain import (
    FRACTIONS,
    WHOLE,
    Span,
    decimal,
    integer,
    take,
    take_if_given,
    take_numbers,
)
from warehouse_sim.dataset.files.run_lengths import compressed, mask_of_runs, run_lengths
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema.classes import CLASS_NUMBERS, class_number, numbered


@dataclass(frozen=True, eq=False)
class FoundObject:
    """One object that somebody found in an image of a dataset."""

    scene_id: int
    image_id: int
    score: float
    """Trust in it, 0-1."""
    class_name: str = ""
    """Its class; empty if unknown."""
    model: str | int | None = None
    """Which object of the dataset it is; None if unknown more than the class."""
    edges: tuple[float, float, float, float] | None = None
    """Left, top, right, bottom of its box (px): a pixel (u, v) reaches from (u, v) to (u + 1, v + 1)."""
    mask: Bool[np.ndarray, "h w"] | None = None
    """Its pixels."""
    kind_likelihood: Mapping[str, float] = field(default_factory=dict)
    """How likely what is seen is of each object, 0-1, by its name; empty if not stated."""


_PIXELS = Span(-1e6, 1e6)


class ImageNumbers:
    """The numbers by which files name a dataset's images.

    Args:
        reader: The dataset.
        images: Those that are named.
    """

    def __init__(self, reader: DatasetReader, images: Iterable[ImageRecord]) -> None:
        self._views = None if reader.manifest is None else reader.manifest.observations_per_scene
        self.by_key: dict[tuple[int, int], ImageRecord] = {(item.scene_id, item.image_id): item for item in images}
        self.by_number = {self.number(*key): item for key, item in self.by_key.items()}

    def number(self, scene_id: int, image_id: int) -> int:
        """Return the number of an image through all scenes, that of its KITTI frame and COCO image."""
        return image_id if self._views is None else scene_id * self._views + image_id


def write_results(path: Path, found: Iterable[FoundObject], reader: DatasetReader) -> None:
    """Write detections as COCO's results, which its tools match with ``coco/annotations/instances_SPLIT.json``.

    Raises:
        DatasetError: A detection has neither a box nor a mask.
        OutputError: The file cannot be written.
    """
    names = _class_of(reader)
    images, rows = ImageNumbers(reader, ()), list[dict[str, Any]]()
    for item in found:
        class_name = item.class_name or names.get(str(item.model), "")
        row: dict[str, Any] = {
            "image_id": images.number(item.scene_id, item.image_id),
            "category_id": class_number(class_name) if class_name else 0,
            "bbox": _bbox(item),
            "score": item.score,
            "scene": item.scene_id,
            "observation": item.image_id,
        }
        if item.model is not None:
            row["object"] = item.model
        if item.mask is not None:
            row["segmentation"] = compressed(run_lengths(item.mask))
        if item.kind_likelihood:
            row["kind_likelihood"] = dict(item.kind_likelihood)
        rows.append(row)
    make_folder(path.parent)
    write_json(path, rows)


def read_results(path: Path, reader: DatasetReader, split: str) -> list[FoundObject]:
    """Read COCO's or BOP's results on a split of a dataset, in their order; images of other splits are passed over.

    Raises:
        DatasetError: The file is malformed, or names an image or a category that the dataset does not have.
    """
    rows = read_json(path)
    if not isinstance(rows, list):
        raise DatasetError(f"{path}: must be a list of detections, as COCO's results are")
    images = ImageNumbers(reader, reader.images(split))
    elsewhere = {
        (item.scene_id, item.image_id) for other in reader.splits if other != split for item in reader.images(other)
    }
    # What a detector knows beside the dataset's classes is read, and is right nowhere.
    classes = {number: name for name, number in numbered(_class_names(reader) | CLASS_NUMBERS.keys()).items()}
    found = list[FoundObject]()
    for index, row in enumerate(rows):
        item = _read_row(row, f"{path}: row {index}", reader, images, classes, elsewhere)
        if item is not None:
            found.append(item)
    return found


def _read_row(
    row: Any,
    where: str,
    reader: DatasetReader,
    images: ImageNumbers,
    classes: Mapping[int, str],
    elsewhere: set[tuple[int, int]],
) -> FoundObject | None:
    number, scene = take(row, "image_id", int, where, WHOLE), take_if_given(row, "scene_id", int, where, WHOLE)
    image = images.by_number.get(number) if scene is None else images.by_key.get((scene, number))
    if image is None:
        if any(images.number(*key) == number if scene is None else key == (scene, number) for key in elsewhere):
            return None
        named = f"image {number}" if scene is None else f"image {number} of scene {scene}"
        raise DatasetError(f"{where}: {reader.root} has no {named}; was the file made for another dataset?")
    category = take(row, "category_id", int, where, WHOLE)
    model: Any = row.get("object") if scene is None else category
    if model is not None and type(model) not in (int, str):
        raise DatasetError(f"{where}: object must be a name or a number of the dataset")
    class_name = classes.get(category, "") if scene is None else ""
    if model is None and not class_name:
        known = ", ".join(f"{number} {name}" for name, number in numbered(_class_names(reader)).items())
        raise DatasetError(f"{where}: category_id {category} is no class of {reader.root}; it has: {known}")
    if isinstance(model, int) and model not in reader.objects:
        raise DatasetError(f"{where}: {reader.root} has no object {model}")
    runs = row.get("segmentation")
    mask = mask_of_runs(runs, (image.camera.height, image.camera.width), where) if isinstance(runs, dict) else None
    edges = None
    if "bbox" in row:
        left, top, width, height = take_numbers(row, "bbox", 4, where, _PIXELS).tolist()
        edges = (left, top, left + width, top + height)
    if edges is None and mask is None:
        raise DatasetError(f"{where}: has neither a bbox nor a segmentation of run lengths")
    score = take(row, "score", float, where, FRACTIONS)
    likely = take_if_given(row, "kind_likelihood", dict, where) or {}
    kinds = {name: take(likely, name, float, f"{where}: kind_likelihood", FRACTIONS) for name in likely}
    return FoundObject(image.scene_id, image.image_id, score, class_name, model, edges, mask, kinds)


def _class_names(reader: DatasetReader) -> set[str]:
    return {info.class_name for info in reader.objects.values()}


def _class_of(reader: DatasetReader) -> dict[str, str]:
    """Return the class of each object by its name and by its number as a word."""
    return {key: info.class_name for number, info in reader.objects.items() for key in (info.name, str(number))}


def _bbox(item: FoundObject) -> list[float]:
    if item.edges is not None:
        left, top, right, bottom = item.edges
        return [left, top, right - left, bottom - top]
    if item.mask is None or not item.mask.any():
        raise DatasetError(f"a detection of scene {item.scene_id}, image {item.image_id} has neither a box nor a mask")
    rows, columns = np.flatnonzero(item.mask.any(axis=1)), np.flatnonzero(item.mask.any(axis=0))
    left, top = float(columns[0]), float(rows[0])
    return [left, top, float(columns[-1]) + 1.0 - left, float(rows[-1]) + 1.0 - top]


CLASSES = "classes.txt"
"""Names of the classes, one a line, beside the labels."""
_LONGEST = 10_000_000


def write_labels(folder: Path, found: Iterable[FoundObject], reader: DatasetReader, split: str) -> None:
    """Write a file for each image of a split, named as those of the dataset's YOLO folder, empty without detections.

    Raises:
        OutputError: The folder cannot be written.
    """
    names, of_model = list(numbered(_class_names(reader))), _class_of(reader)
    by_image: dict[tuple[int, int], list[FoundObject]] = {}
    for item in found:
        by_image.setdefault((item.scene_id, item.image_id), []).append(item)
    make_folder(folder)
    write_bytes(folder / CLASSES, ("\n".join(names) + "\n").encode())
    for image in reader.images(split):
        lines = list[str]()
        for item in by_image.get((image.scene_id, image.image_id), []):
            class_name = item.class_name or of_model.get(str(item.model), "")
            if item.edges is None or class_name not in names:
                continue
            left, top, right, bottom = item.edges
            width, height = image.camera.width, image.camera.height
            fractions = (left + right) / 2 / width, (top + bottom) / 2 / height, (right - left) / width
            numbers = (*fractions, (bottom - top) / height, item.score)
            lines.append(" ".join([str(names.index(class_name)), *(f"{number:.6f}" for number in numbers)]))
        path = folder / f"{image.scene_id:06d}_{image.image_id:06d}.txt"
        write_bytes(path, "".join(f"{line}\n" for line in lines).encode())


def is_label_folder(folder: Path) -> bool:
    """Return whether a folder holds detections as label files."""
    return (folder / CLASSES).is_file() or (folder / "labels").is_dir()


def read_labels(folder: Path, reader: DatasetReader, split: str) -> list[FoundObject]:
    """Read the label files of a split's images; an image without a file has no detections.

    Files are named SCENE_OBSERVATION, as those of the dataset's YOLO folder, or by the number of the image through all
    scenes. Without ``classes.txt`` classes are those of the dataset in order of their numbers, as in ``data.yaml``.

    Raises:
        DatasetError: A file is malformed, or there is none at all.
    """
    labels = folder / "labels" if (folder / "labels").is_dir() else folder
    names = list(numbered(_class_names(reader)))
    if (folder / CLASSES).is_file():
        names = (folder / CLASSES).read_text(encoding="utf-8").split()
    images = ImageNumbers(reader, reader.images(split))
    found, files = list[FoundObject](), 0
    for image in images.by_key.values():
        number = images.number(image.scene_id, image.image_id)
        stems = (f"{image.scene_id:06d}_{image.image_id:06d}", f"{number:06d}", str(number))
        path = next((path for stem in stems if (path := labels / f"{stem}.txt").is_file()), None)
        if path is not None:
            files += 1
            found += _read_file(path, image, names)
    if not files:
        raise DatasetError(f"{labels}: has no label file of an image of {split!r}, such as 000000_000000.txt")
    return found


def _read_file(path: Path, image: ImageRecord, names: list[str]) -> list[FoundObject]:
    if path.stat().st_size > _LONGEST:
        raise DatasetError(f"{path}: is no label file, it has {path.stat().st_size} bytes")
    found = list[FoundObject]()
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        words = line.split()
        if not words:
            continue
        try:
            index, values = integer(words[0]), [decimal(word) for word in words[1:]]
        except ValueError as problem:
            raise DatasetError(f"{path}: line {number} holds something else than numbers") from problem
        if len(values) not in (4, 5) or not all(-1.0 <= value <= 2.0 for value in values):
            raise DatasetError(f"{path}: line {number} must be a class and x y w h, perhaps a score, as fractions")
        if not 0 <= index < len(names):
            raise DatasetError(f"{path}: line {number} has the class {index}; known: {', '.join(names)}")
        x, y, w, h = values[:4]
        size_w, size_h = image.camera.width, image.camera.height
        edges = ((x - w / 2) * size_w, (y - h / 2) * size_h, (x + w / 2) * size_w, (y + h / 2) * size_h)
        score = min(1.0, max(0.0, values[4])) if len(values) == 5 else 1.0
        found.append(FoundObject(image.scene_id, image.image_id, score, names[index], edges=edges))
    return found
