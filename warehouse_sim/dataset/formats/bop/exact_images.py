"""Images of exact data of a BOP scene: normals, object coordinates, and classes with the table of their values.

Directions and positions are 16-bit PNG: one number of a channel is one step, 0 0 0 is nothing. Steps are as fine as 16
bits allow: 3.1e-5 of a unit vector, 1.5e-5 of an edge of an object's box.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float32, Int32, UInt16

from warehouse_sim.dataset.files.extent import Source, read_bytes, where_of
from warehouse_sim.dataset.files.json_file import read_table
from warehouse_sim.dataset.files.plain import Span, take
from warehouse_sim.dataset.files.png import encode_png, require_whole_png
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import Observation
from warehouse_sim.schema.classes import class_number, mask_values

NORMAL_MIDDLE, NORMAL_STEPS = 32768, 32767
"""What a normal's 0 is stored as, and the steps from there to 1 and to -1."""
COORDINATE_FIRST, COORDINATE_STEPS = 1, 65534
"""What a coordinate's 0 is stored as, and the steps from there to 1."""
_NUMBERS = Span(1, 2**31 - 1)


class ClassTable:
    """Which value of a scene's class masks stands for which class.

    Args:
        names: Classes of the scene.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._values = mask_values(names)

    @property
    def rows(self) -> dict[int, dict[str, Any]]:
        """What the scene's table holds: name and number of the class of each value."""
        return {value: {"class_name": name, "class_number": class_number(name)} for name, value in self._values.items()}

    def encode(self, numbers: Int32[np.ndarray, "h w"]) -> bytes:
        """Return the 16-bit PNG of an image of class numbers.

        Raises:
            DatasetError: It shows a class that is none of the scene's.
        """
        image, known = np.zeros(numbers.shape, np.uint16), numbers == 0
        for name, value in self._values.items():
            shown = numbers == class_number(name)
            image[shown] = value
            known |= shown
        if not known.all():
            raise DatasetError(f"class mask: {int(numbers[~known][0])} is the number of no class of the scene")
        return encode_png(image, "up")


def read_class_table(path: Path) -> dict[int, str]:
    """Return the name of the class of each value in a scene's class masks.

    Raises:
        DatasetError: The table is missing or malformed.
    """
    rows = read_table(path)
    found = {}
    for value, row in rows.items():
        where = f"{path}: {value}"
        found[value] = take(row, "class_name", str, where)
        if take(row, "class_number", int, where, _NUMBERS) != class_number(found[value]):
            raise DatasetError(f"{where}: class_number is not that of {found[value][:80]!r}")
    return found


def require_known_values(image: UInt16[np.ndarray, "h w"], names: dict[int, str], where: str) -> None:
    """Reject a class mask with a value that the table does not name.

    Raises:
        DatasetError: It has one.
    """
    if unknown := set(np.unique(image).tolist()) - {0, *names}:
        raise DatasetError(f"{where}: holds {min(unknown)}, which scene_class_mask.json does not name")


def exact_files(table: ClassTable) -> dict[str, Callable[[Observation], bytes]]:
    """Return how the file of each kind of exact image is made of an observation that holds it."""
    return {
        "normals": lambda item: encode_normals(_made(item.buffers.normals, "normals")),
        "object_coordinates": lambda item: encode_coordinates(_made(item.object_coordinates, "object_coordinates")),
        "class_mask": lambda item: table.encode(_made(item.class_numbers, "class_mask")),
    }


def _made(image: np.ndarray | None, name: str) -> np.ndarray:
    if image is None:
        raise DatasetError(f"{name}: the dataset promises it, but the observation has none; observe it with outputs")
    return image


def encode_normals(normals: Float32[np.ndarray, "h w 3"]) -> bytes:
    """Return the PNG of unit vectors; zeros, which are no direction, stay zeros."""
    there = np.any(normals, axis=2, keepdims=True)
    steps = np.rint(np.clip(normals, -1.0, 1.0) * np.float32(NORMAL_STEPS)) + NORMAL_MIDDLE
    return encode_png((steps * there).astype(np.uint16), "up")


def decode_normals(source: Source) -> Float32[np.ndarray, "h w 3"]:
    """Read unit vectors, zeros where there is none.

    Raises:
        DatasetError: The file is no 16-bit colour PNG, or holds a vector that is not 1 long.
    """
    stored = _decode(source)
    there = stored.any(axis=2)
    found = (stored.astype(np.float32) - NORMAL_MIDDLE) / np.float32(NORMAL_STEPS)
    found[~there] = 0.0
    length = np.linalg.norm(found[there], axis=1)
    if np.abs(length - 1.0).max(initial=0.0) > 1e-3:
        raise DatasetError(f"{where_of(source)}: holds normals that are not 1 long; generate the dataset again")
    return found


def encode_coordinates(coordinates: Float32[np.ndarray, "h w 3"]) -> bytes:
    """Return the PNG of positions of 0 to 1 along each edge of a box, NaN where there is none.

    The little by which a surface leaves its nominal box is cut off.
    """
    there = np.isfinite(coordinates).all(axis=2, keepdims=True)
    inside = np.clip(np.where(there, coordinates, 0.0), 0.0, 1.0)
    steps = np.rint(inside * COORDINATE_STEPS) + COORDINATE_FIRST
    return encode_png((steps * there).astype(np.uint16), "up")


def decode_coordinates(source: Source) -> Float32[np.ndarray, "h w 3"]:
    """Read positions of 0 to 1 along each edge of a box, NaN where there is none.

    Raises:
        DatasetError: The file is no 16-bit colour PNG, or holds a position with a channel missing.
    """
    stored = _decode(source)
    there = stored.any(axis=2)
    if not stored[there].all():
        raise DatasetError(f"{where_of(source)}: holds coordinates of less than three axes; generate the dataset again")
    found = (stored.astype(np.float32) - COORDINATE_FIRST) / np.float32(COORDINATE_STEPS)
    found[~there] = np.nan
    return found


def _decode(source: Source) -> UInt16[np.ndarray, "h w 3"]:
    data, where = read_bytes(source), where_of(source)
    require_whole_png(data, where)
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.dtype != np.uint16 or image.ndim != 3 or image.shape[2] != 3:
        found = "no image" if image is None else f"{image.dtype} of shape {image.shape}"
        raise DatasetError(f"{where}: expected a 16-bit colour image, found {found}")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint16)
