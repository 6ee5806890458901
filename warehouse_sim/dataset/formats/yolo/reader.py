"""Read a third-party YOLO folder (or of one task of ours): images, classes, boxes masks of polygons; no poses."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.files.image_io import image_size_wh
from warehouse_sim.dataset.files.plain import WHOLE, decimal
from warehouse_sim.dataset.formats.reader_base import (
    ImagesOnly,
    box_mask,
    guessed_camera,
    inside,
    shapeless,
)
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import NO_POSE, ImageRecord, TargetRecord
from warehouse_sim.dataset.split import require_split
from warehouse_sim.errors import DatasetError, WarehouseSimError, shown
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.yaml_file import read_yaml

_SPLITS = {"train": ("train",), "val": ("val", "valid", "validation"), "test": ("test",)}
_BEYOND = 0.01
"""Tools take shares that leave the image by so much."""
_MOST_CLASSES = 100_000
_FLAGS = (0, 1, 2)
"""Of key points: not labelled, hidden, seen."""


@dataclass(frozen=True)
class YoloData:
    """What data.yaml says."""

    names: dict[int, str]
    """Classes by number, from 0."""
    folders: dict[str, str]
    """Folder of the images of each split, in the dataset."""
    points_shape: tuple[int, int]
    """Number of key points after a box, and columns of each: x, y, perhaps a flag; 0, 0 = none."""


@dataclass(frozen=True, eq=False)
class Label:
    """A row of a label file, in fractions of the image's width and height."""

    number: int
    box_xyxy: Float[np.ndarray, " 4"]
    """Outer edges."""
    polygon: Float[np.ndarray, "n 2"] | None
    """None where the row is a box."""


def read_data(root: Path) -> YoloData:
    """Read ``data.yaml``; a ``path`` in it, which says where others had the folder, is passed over.

    Raises:
        DatasetError: It is missing, or does not name classes and folders.
    """
    path = root / "data.yaml"
    try:
        data = read_yaml(path)
    except WarehouseSimError as problem:
        raise DatasetError(str(problem)) from problem
    if not isinstance(data, dict):
        raise DatasetError(f"{path}: must map names to values, found {shown(data)}")
    folders = {}
    for split, keys in _SPLITS.items():
        given = next((data[key] for key in keys if data.get(key)), None)
        if isinstance(given, str):
            # Exported folders are often written as seen from a folder beside them.
            folders[split] = given.removeprefix("../").removeprefix("./").rstrip("/")
        elif given is not None:
            raise DatasetError(f"{path}: {split} must be one folder of images, found {shown(given)}")
    if not folders:
        raise DatasetError(f"{path}: names no folder of images under train, val or test")
    return YoloData(_names(data.get("names"), str(path)), folders, _points_shape(data.get("kpt_shape"), str(path)))


def read_labels(path: Path, data: YoloData) -> list[Label]:
    """Read a label file; an image without one shows nothing.

    Raises:
        DatasetError: A row is neither box nor polygon, or leaves the image.
    """
    if not path.is_file():
        return []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); copy the dataset again") from problem
    rows = [(f"{path}:{i}", line.split()) for i, line in enumerate(lines, start=1) if line.strip()]
    return [_label(row, where, data) for where, row in rows]


def _label(row: list[str], where: str, data: YoloData) -> Label:
    try:
        values = np.array([decimal(item) for item in row])
    except ValueError as problem:
        raise DatasetError(f"{where}: must be numbers ({problem})") from problem
    points = np.zeros((0, 2))
    count, columns = data.points_shape
    if count and values.size == 5 + count * columns:
        values, points = values[:5], values[5:].reshape(count, columns)
    if values.size != 5 and (values.size < 7 or values.size % 2 == 0):
        raise DatasetError(f"{where}: has {values.size} numbers; a box has 5, a polygon 7, 9, ...")
    if values[0] not in data.names:
        raise DatasetError(f"{where}: class {row[0][:20]} is not in data.yaml, which has {len(data.names)} classes")
    fractions = values[1:]
    positions = np.concatenate([fractions, points[:, :2].ravel()])
    if not ((positions >= -_BEYOND) & (positions <= 1 + _BEYOND)).all():
        raise DatasetError(f"{where}: positions must be fractions of the image, 0 to 1, found {shown(row[1:5])}")
    if not np.isin(points[:, 2:], _FLAGS).all():
        raise DatasetError(f"{where}: flags of key points must be 0, 1 or 2, found {shown(points[:, 2].tolist())}")
    number = int(values[0])
    if values.size == 5:
        centre, half = fractions[:2], fractions[2:] / 2
        return Label(number, np.clip(np.concatenate([centre - half, centre + half]), 0, 1), None)
    polygon = np.clip(fractions.reshape(-1, 2), 0, 1)
    return Label(number, np.concatenate([polygon.min(axis=0), polygon.max(axis=0)]), polygon)


def _names(given: Any, where: str) -> dict[int, str]:
    listed = dict(enumerate(given)) if isinstance(given, list) else given
    if not isinstance(listed, dict) or not 0 < len(listed) <= _MOST_CLASSES:
        raise DatasetError(f"{where}: names must list the classes, found {shown(given)}")
    for number, name in listed.items():
        if type(number) is not int or number not in WHOLE or not isinstance(name, str | int):
            raise DatasetError(f"{where}: names must give each class a number >= 0, found {shown({number: name})}")
    return {number: str(name) for number, name in sorted(listed.items())}


def _points_shape(given: Any, where: str) -> tuple[int, int]:
    if given is None:
        return 0, 0
    if (
        not isinstance(given, list)
        or len(given) != 2
        or not all(type(item) is int and 0 < item < 1000 for item in given)
        or given[1] not in (2, 3)
    ):
        raise DatasetError(f"{where}: kpt_shape must be points and 2 or 3, found {shown(given)}")
    return given[0], given[1]


_ENDINGS = frozenset((".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"))


class YoloReader(ImagesOnly):
    """A folder with a ``data.yaml``; classes are numbered from 1 here, as objects are.

    Args:
        root: The folder.
    """

    lacks = ("ground-truth masks",)
    """Polygons stand for them."""

    def __init__(self, root: Path) -> None:
        self._data: YoloData = read_data(root)
        super().__init__(root, self._data.folders)
        self._files: dict[str, list[Path]] = {}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The classes, of whose shape nothing is known, by number + 1."""
        return {number + 1: shapeless(number + 1, name, self.root) for number, name in self._data.names.items()}

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Each split is one scene."""
        return {split: (number,) for number, split in enumerate(self._data.folders)}

    def _read(self, split: str) -> list[ImageRecord]:
        """Return the images in order of their names."""
        return [self._image(split, i, path) for i, path in enumerate(self._paths(split))]

    def files(self, split: str) -> list[Path]:
        """Return images and labels of a split, sorted."""
        require_split(self.root, split, self._data.folders)
        labels = [path for path in map(label_path, self._paths(split)) if path.is_file()]
        return sorted([*self._paths(split), *labels])

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target; its box where its label is no polygon."""
        label = self._labels(image.split, image.image_id)[gt_index]
        if label.polygon is None:
            return box_mask(image.targets[gt_index].box_visible_xyxy, image.camera, halves_up=True)
        return _filled(label.polygon, image.camera.width, image.camera.height)

    def _file(self, image: ImageRecord, kind: str) -> Path:
        return self._paths(image.split)[image.image_id]

    def _paths(self, split: str) -> list[Path]:
        if split not in self._files:
            folder = inside(self.root, self._data.folders[split], f"{self.root / 'data.yaml'}: {split}")
            if not folder.is_dir():
                raise DatasetError(f"{self.root / 'data.yaml'}: {split} is {folder}, which is no folder in the dataset")
            found = (path for path in folder.rglob("*") if path.suffix.lower() in _ENDINGS)
            self._files[split] = sorted(found)
        return self._files[split]

    def _labels(self, split: str, image_id: int) -> list[Label]:
        return read_labels(label_path(self._paths(split)[image_id]), self._data)

    def _image(self, split: str, image_id: int, path: Path) -> ImageRecord:
        width, height = image_size_wh(path)
        targets = [_target(i, label, width, height) for i, label in enumerate(self._labels(split, image_id))]
        camera, (scene_id,) = guessed_camera(width, height), self.splits[split]
        return ImageRecord(split, scene_id, image_id, camera, np.eye(4), 1.0, tuple(targets), calibrated=False)


def label_path(image: Path) -> Path:
    """Return the label file of an image: the last folder ``images`` of its path becomes ``labels``."""
    parts: list[Any] = list(image.parts)
    folders = [i for i, part in enumerate(parts[:-1]) if part == "images"]
    if folders:
        parts[folders[-1]] = "labels"
    return Path(*parts).with_suffix(".txt")


def _target(index: int, label: Label, width: int, height: int) -> TargetRecord:
    left, top, right, bottom = label.box_xyxy * [width, height, width, height]
    box = float(left), float(top), max(float(right) - 1, float(left)), max(float(bottom) - 1, float(top))
    seen = round((box[2] - box[0] + 1) * (box[3] - box[1] + 1))
    if label.polygon is not None:
        mask = _filled(label.polygon, width, height)
        found = mask_box_xyxy(mask)
        if found is not None:
            box, seen = (float(found[0]), float(found[1]), float(found[2]), float(found[3])), int(mask.sum())
    return TargetRecord(index, label.number + 1, 0, NO_POSE, 1.0, seen, box, box, seen, max(seen, 1))


def _filled(polygon: Float[np.ndarray, "n 2"], width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """Return the pixels of a polygon given in fractions of the image, filled as Ultralytics does."""
    image = np.zeros((height, width), dtype=np.uint8)
    cv2.fillPoly(image, [np.trunc(polygon * [width, height]).astype(np.int32)], 1)
    return image.view(bool)
