"""Detections as YOLO's label files: a text file an image, a row ``class x y w h score`` for each, as fractions."""

from collections.abc import Iterable
from pathlib import Path

from warehouse_sim.dataset.files.plain import decimal
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.results.detection_file import ImageNumbers
from warehouse_sim.dataset.results.found_object import FoundObject
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import make_folder, write_bytes

CLASSES = "classes.txt"
"""Names of the classes, one a line, beside the labels."""
_LONGEST = 10_000_000


def write_labels(folder: Path, found: Iterable[FoundObject], reader: DatasetReader, split: str) -> None:
    """Write a file for each image of a split, named as those of the dataset's YOLO folder, empty without detections.

    Raises:
        OutputError: The folder cannot be written.
    """
    names = sorted({info.class_name for info in reader.objects.values()})
    of_model = {key: info.class_name for number, info in reader.objects.items() for key in (number, info.name)}
    by_image: dict[tuple[int, int], list[FoundObject]] = {}
    for item in found:
        by_image.setdefault((item.scene_id, item.image_id), []).append(item)
    make_folder(folder)
    write_bytes(folder / CLASSES, ("\n".join(names) + "\n").encode())
    for image in reader.images(split):
        lines = list[str]()
        for item in by_image.get((image.scene_id, image.image_id), []):
            class_name = item.class_name or of_model.get(item.model or 0, "")
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
    scenes. Without ``classes.txt`` classes are the dataset's in alphabetical order, as YOLO's ``data.yaml`` has them.

    Raises:
        DatasetError: A file is malformed, or there is none at all.
    """
    labels = folder / "labels" if (folder / "labels").is_dir() else folder
    names = sorted({info.class_name for info in reader.objects.values()})
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
            index, values = int(words[0]), [decimal(word) for word in words[1:]]
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
