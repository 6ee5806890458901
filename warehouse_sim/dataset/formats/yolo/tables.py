"""data.yaml and label files of a YOLO folder made by third parties."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.files.plain import WHOLE, shown
from warehouse_sim.errors import DatasetError, WarehouseSimError
from warehouse_sim.yaml_file import read_yaml

_SPLITS = {"train": ("train",), "val": ("val", "valid", "validation"), "test": ("test",)}
_BEYOND = 0.01
"""Tools take shares that leave the image by so much."""
_MOST_CLASSES = 100_000


@dataclass(frozen=True)
class YoloData:
    """What data.yaml says."""

    names: dict[int, str]
    """Classes by number, from 0."""
    folders: dict[str, str]
    """Folder of the images of each split, in the dataset."""
    point_columns: int
    """Columns of key points after a box; 0 = none."""


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
    return YoloData(_names(data.get("names"), str(path)), folders, _point_columns(data.get("kpt_shape"), str(path)))


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
        values = np.array([float(item) for item in row])
    except ValueError as problem:
        raise DatasetError(f"{where}: must be numbers ({problem})") from problem
    if values.size == 5 + data.point_columns:
        values = values[:5]
    if values.size != 5 and (values.size < 7 or values.size % 2 == 0):
        raise DatasetError(f"{where}: has {values.size} numbers; a box has 5, a polygon 7, 9, ...")
    if values[0] not in data.names:
        raise DatasetError(f"{where}: class {row[0][:20]} is not in data.yaml, which has {len(data.names)} classes")
    fractions = values[1:]
    if not ((fractions >= -_BEYOND) & (fractions <= 1 + _BEYOND)).all():
        raise DatasetError(f"{where}: positions must be fractions of the image, 0 to 1, found {shown(row[1:5])}")
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


def _point_columns(given: Any, where: str) -> int:
    if given is None:
        return 0
    if (
        not isinstance(given, list)
        or len(given) != 2
        or not all(type(item) is int and 0 < item < 1000 for item in given)
    ):
        raise DatasetError(f"{where}: kpt_shape must be points and 2 or 3, found {shown(given)}")
    points, columns = given
    return int(points * columns)
