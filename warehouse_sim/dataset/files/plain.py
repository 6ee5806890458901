"""Between numpy and plain JSON data: what is read is typed and in range, or an error names file, key and value."""

import re
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Fisheye, Lens, lens_of
from warehouse_sim.geometry.pose import Transform

_COUNTS = {"distortion": 5, "fisheye": 4}


def lens_row(camera: PinholeCamera, prefix: str = "") -> dict[str, Any]:
    """Return the coefficients of the camera's lens under the key of its kind; nothing without a lens."""
    lens = camera.distortion
    if lens is None:
        return {}
    return {prefix + ("fisheye" if isinstance(lens, Fisheye) else "distortion"): list(lens.coefficients)}


def read_lens(data: dict[str, Any], where: str, prefix: str = "") -> Lens | None:
    """Read what ``lens_row`` returns; None where there is no lens.

    Raises:
        DatasetError: Two kinds of lens, or coefficients of none.
    """
    given = [kind for kind in _COUNTS if prefix + kind in data]
    if not given:
        return None
    if len(given) > 1:
        raise DatasetError(f"{where}: {prefix}distortion and {prefix}fisheye are two kinds of lens: one is expected")
    key = prefix + given[0]
    try:
        return lens_of(take_numbers(data, key, _COUNTS[given[0]], where).tolist())
    except ValueError as problem:
        raise DatasetError(f"{where}: {key}: {problem}") from problem


T = TypeVar("T")


@dataclass(frozen=True)
class Span:
    """A range of numbers, both ends included."""

    low: float
    high: float

    def __contains__(self, number: float) -> bool:
        return self.low <= number <= self.high

    def __str__(self) -> str:
        return f"{self.low:.12g} to {self.high:.12g}"


NUMBERS = Span(-1e15, 1e15)
"""Any number that is still exact to an eighth."""
WHOLE = Span(0, 2**31 - 1)
"""Indices and counts."""
FRACTIONS = Span(0.0, 1.0)
LENGTHS = Span(1e-4, 1e4)
"""Edges and distances within an object (m): a hair to a town."""
PLACES = Span(-1e6, 1e6)
"""Coordinates and distances (m)."""
PIXELS = Span(1, 65_535)
"""Edges of an image (px)."""

_LARGEST_SKEW = 1e-2
"""How far a rounded rotation may be from one."""
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.~+-]{0,99}")


def take(data: Any, key: str, kind: type[T], where: str, span: Span | None = None) -> T:
    """Return ``data[key]``, which must be of type ``kind`` and, if it is a number, in ``span``.

    A whole number passes for a float.

    Raises:
        DatasetError: No such key, or a value of another type or out of range.
    """
    if not isinstance(data, dict) or key not in data:
        raise DatasetError(f"{where}: the entry {key!r} is missing")
    value = data[key]
    if kind is float and type(value) is int:
        value = float(value)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise DatasetError(f"{where}: {key} must be of type {kind.__name__}, found {shown(value)}")
    if span is not None and isinstance(value, (int, float)) and value not in span:
        raise DatasetError(f"{where}: {key} must be {span}, found {shown(value)}")
    return value


def take_if_given(data: Any, key: str, kind: type[T], where: str, span: Span | None = None) -> T | None:
    """Return what ``take`` does, None where the key is missing or null."""
    if isinstance(data, dict) and data.get(key) is None:
        return None
    return take(data, key, kind, where, span)


def take_numbers(data: Any, key: str, count: int, where: str, span: Span = NUMBERS) -> Float[np.ndarray, " count"]:
    """Return a list of ``count`` numbers, each in ``span``.

    Raises:
        DatasetError: As ``take``.
    """
    values = take(data, key, list, where)
    if len(values) != count or not all(type(value) in (int, float) for value in values):
        raise DatasetError(f"{where}: {key} must be {count} numbers, found {shown(values)}")
    if not all(value in span for value in values):
        raise DatasetError(f"{where}: {key} must be {count} numbers, each {span}, found {shown(values)}")
    return np.array(values, dtype=float)


def decimal(word: str) -> float:
    """Return the number that a word of a text file says; Python alone reads 1_0 as 10, and digits of other scripts.

    Raises:
        ValueError: It says none.
    """
    if "_" in word or not word.isascii():
        raise ValueError(f"could not convert string to float: {word!r}")
    return float(word)


def integer(word: str) -> int:
    """Return the whole number that a word of a text file says, as strictly as ``decimal`` does.

    Raises:
        ValueError: It says none.
    """
    if not re.fullmatch(r"[-+]?[0-9]{1,18}", word):
        raise ValueError(f"invalid literal for a whole number: {word[:40]!r}")
    return int(word)


def take_name(data: Any, key: str, where: str) -> str:
    """Return a name that is one word and cannot lead out of a folder.

    Raises:
        DatasetError: As ``take``, or other characters than letters, digits and _ . ~ + -.
    """
    name = take(data, key, str, where)
    if not _NAME.fullmatch(name):
        raise DatasetError(f"{where}: {key} must be a word of letters, digits and _ . ~ + -, found {shown(name)}")
    return name


def read_transform(data: Any, where: str) -> Transform:
    """Read a 4x4 rigid transform.

    Raises:
        DatasetError: Not four rows of four numbers, no rigid transform, or one that leads too far away.
    """
    rows = data if isinstance(data, list) else []
    flat = [value for row in rows if isinstance(row, list) and len(row) == 4 for value in row]
    if len(rows) != 4 or len(flat) != 16 or not all(type(value) in (int, float) for value in flat):
        raise DatasetError(f"{where}: is not a rigid 4x4 transform: {shown(data)}")
    T_a_b = np.array(flat, dtype=float).reshape(4, 4)
    if not is_rigid(T_a_b):
        raise DatasetError(f"{where}: is not a rigid 4x4 transform: {shown(data)}")
    if not all(value in PLACES for value in T_a_b[:3, 3]):
        raise DatasetError(f"{where}: must lead {PLACES} m along each axis, found {T_a_b[:3, 3].tolist()}")
    return T_a_b


def nearest_rotation(R: Float[np.ndarray, "3 3"], where: str) -> Float[np.ndarray, "3 3"]:
    """Return the rotation next to one whose numbers were rounded, as others do.

    Raises:
        DatasetError: It is far from any rotation.
    """
    U, _, Vt = np.linalg.svd(np.clip(R, -2.0, 2.0))
    nearest: Float[np.ndarray, "3 3"] = U @ Vt
    if np.linalg.det(nearest) < 0 or np.abs(nearest - R).max() > _LARGEST_SKEW:
        raise DatasetError(f"{where} is not a rotation: {shown(R.ravel().tolist())}")
    return nearest


def is_rigid(T_a_b: Transform, tolerance: float = 1e-6) -> bool:
    """Say whether a 4x4 matrix is finite, orthonormal to ``tolerance``, with determinant +1 and last row 0 0 0 1."""
    R = T_a_b[:3, :3]
    return bool(
        np.isfinite(T_a_b).all()
        # Before the product, which would overflow.
        and np.abs(R).max() <= 2.0
        and np.abs(R @ R.T - np.eye(3)).max() <= tolerance
        and np.linalg.det(R) > 0
        and np.array_equal(T_a_b[3], [0, 0, 0, 1])
    )
