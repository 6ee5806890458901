"""Records: dataclasses whose fields are the entries of a JSON object, read and written by the one codec."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from jaxtyping import Float

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.files.plain import (
    LENGTHS,
    NUMBERS,
    PIXELS,
    Span,
    lens_row,
    read_lens,
    read_transform,
    take,
    take_name,
    take_numbers,
)
from warehouse_sim.errors import ConfigError, DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range


class Record:
    """Base of what a dataset's JSON holds."""

    called: ClassVar[str] = "an entry"

    @classmethod
    def read(cls, data: Any, where: str) -> Self:
        """Read a record strictly.

        Raises:
            DatasetError: An entry is missing, unknown, of another type or out of range.
        """
        try:
            return from_mapping(cls, data, where)
        except ConfigError as problem:
            raise DatasetError(str(problem)) from problem

    def row(self) -> dict[str, Any]:
        """Return the record as plain data."""
        plain: dict[str, Any] = to_mapping(self)
        return plain


class _Rigid:
    from_plain = staticmethod(read_transform)


class _Name:
    @staticmethod
    def from_plain(value: Any, where: str) -> str:
        place, _, key = where.rpartition(": ")
        return take_name({key: value}, key, place)


@dataclass(frozen=True)
class _Numbers:
    count: int
    span: Span

    def from_plain(self, value: Any, where: str) -> Float[np.ndarray, " count"]:
        place, _, key = where.rpartition(": ")
        return take_numbers({key: value}, key, self.count, place, self.span)


Rigid = Annotated[Transform, _Rigid()]
"""A rigid 4x4 transform, four rows of four numbers."""
Name = Annotated[str, _Name()]
"""A word that cannot lead out of a folder."""
Length = Annotated[float, Range(1e-4, 1e4, "m")]
"""An edge or a distance within an object (m)."""
Lengths = Annotated[Float[np.ndarray, " 3"], _Numbers(3, LENGTHS)]
"""Three edges (m)."""
Whole = Annotated[int, Range(0, 2**31 - 1)]
"""An index or a count."""
Place = Annotated[float, Range(-1e6, 1e6, "m")]
"""A coordinate or a distance (m)."""
_FOCAL = Span(1e-3, 1e7)


def camera_row(camera: PinholeCamera) -> dict[str, Any]:
    """Return plain data of a camera with its lens."""
    return {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")} | lens_row(camera)


def read_camera_row(data: dict[str, Any], where: str) -> PinholeCamera:
    """Read what ``camera_row`` returns.

    Raises:
        DatasetError: An entry is missing or malformed, or they are those of no camera.
    """
    width, height = (take(data, key, int, where, PIXELS) for key in ("width", "height"))
    fx, fy = (take(data, key, float, where, _FOCAL) for key in ("fx", "fy"))
    cx, cy = (take(data, key, float, where, NUMBERS) for key in ("cx", "cy"))
    try:
        return PinholeCamera(width, height, fx, fy, cx, cy, read_lens(data, where))
    except ValueError as problem:
        raise DatasetError(f"{where}: {problem}") from problem
