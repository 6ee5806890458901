"""Images of exact data of a BOP scene: normals, object coordinates, and classes with the table of their values."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Int32, UInt16

from warehouse_sim.dataset.files.dense_images import encode_coordinates, encode_normals
from warehouse_sim.dataset.files.json_file import read_table
from warehouse_sim.dataset.files.plain import Span, take
from warehouse_sim.dataset.files.png import encode_png
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import Observation
from warehouse_sim.schema.classes import class_number, mask_values

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
