"""The BOP pose CSV: ``scene_id,im_id,obj_id,score,R,t,time`` with R row-major and t in millimetres."""

import sys
from collections.abc import Iterable, Iterator
from itertools import islice
from math import isfinite
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.files.plain import decimal, is_rigid
from warehouse_sim.errors import DatasetError, InputError, shown
from warehouse_sim.geometry.pose import Transforms, make_transform
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import PoseEstimate

_TOLERANCE = 1e-2
"""How far rotations may be from orthonormal: files from elsewhere may hold few digits."""
_LARGEST, _LARGEST_WHOLE = sys.float_info.max, 10**18
FARTHEST_ERROR = 1e6
"""No error of a pose is larger (m)."""
_FARTHEST = 300.0
"""Any object of a warehouse is nearer to the camera (m)."""


def require_estimates(found: Any, where: str) -> list[PoseEstimate]:
    """Return estimates as a list.

    Args:
        found: What should be a list of estimates.
        where: Where it comes from, for messages.

    Raises:
        InputError: It is no list, or an estimate in it cannot be used.
    """
    has_items = (
        isinstance(found, Iterable) and getattr(found, "ndim", 1) != 0
    )  # arrays and tensors of no axis have none
    if not has_items or isinstance(found, (str, bytes, dict)):
        raise InputError(f"{where} must be a list of PoseEstimate, found {shown(found)}")
    estimates = list(found)
    for number, item in enumerate(estimates):
        problem = estimate_fault(item)
        if problem is not None:
            raise InputError(f"{where}: estimate {number}: {problem}")
    return estimates


def estimate_fault(item: Any) -> str | None:
    """Return what is wrong with an estimate; None if nothing is."""
    if not isinstance(item, PoseEstimate):
        return f"must be a PoseEstimate, found {shown(item)}"
    for name in ("scene_id", "image_id", "obj_id", "detection"):
        value = getattr(item, name)
        if not isinstance(value, Integral) or isinstance(value, bool) or abs(int(value)) >= _LARGEST_WHOLE:
            return f"{name} must be a whole number, found {shown(value)}"
    for name in ("score", "time"):
        value = getattr(item, name)
        if not _is_within(value, -_LARGEST, _LARGEST):
            return f"{name} must be a finite number, found {shown(value)}"
    for name in ("predicted_error", "error_bound"):
        value = getattr(item, name)
        if value is not None and not _is_within(value, 0.0, FARTHEST_ERROR):
            return f"{name} must be a distance (m) or None, found {shown(value)}"
    if not isinstance(item.name, str) or not isinstance(item.class_name, str):
        return f"name and class_name must be text, found {shown(item.name)} and {shown(item.class_name)}"
    covariance = item.covariance
    if covariance is not None and not (_is_array(covariance, (6, 6)) and np.isfinite(covariance).all()):
        return f"covariance must be a 6 x 6 array of finite numbers or None, found {shown(covariance)}"
    return _pose_fault(item.T_camera_object)


def _pose_fault(T: Any) -> str | None:
    if not _is_array(T, (4, 4)):
        return f"T_camera_object must be a 4 x 4 array, found {shown(T)}"
    if (far := float(np.abs(T[:3, 3]).max())) > _FARTHEST:
        return f"T_camera_object says that the object is {far:,.0f} m away; give metres, not millimetres"
    if not is_rigid(T.astype(float), _TOLERANCE):
        return f"T_camera_object must be a rotation and a translation (m), found {shown(T.tolist())}"
    return None


def _is_within(value: Any, low: float, high: float) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and low <= value <= high  # type: ignore[operator]


def _is_array(value: Any, shape: tuple[int, int]) -> bool:
    return isinstance(value, np.ndarray) and value.shape == shape and value.dtype.kind in "fiu"


_HEADER = "scene_id,im_id,obj_id,score,R,t,time"
# In characters; a row with all digits of its numbers has about 350. What is no CSV may have no line end at all.
_LONGEST_LINE = 4096
_FARTHEST_MM = 1e7
_AT_ONCE = 1000
"""Lines whose poses are checked in one go."""


def write(path: Path, estimates: Iterable[PoseEstimate]) -> None:
    """Write estimates, one a line, with every digit of their float64 values.

    Raises:
        DatasetError: A value is not finite, or the rows of one image differ in time.
    """
    rows = list(estimates)
    for row in rows:
        if not np.isfinite([row.score, row.time, *row.T_camera_object.ravel()]).all():
            raise DatasetError(f"{path}: the estimate of obj_id {row.obj_id} in {_image(row)} is not finite")
    _require_one_time(rows, str(path))
    lines = [_HEADER, *map(_line, rows)]
    make_folder(path.parent)
    write_bytes(path, ("\n".join(lines) + "\n").encode("ascii"), durable=True)


def read(path: Path) -> list[PoseEstimate]:
    """Read estimates in file order; a UTF-8 mark, Windows line ends and blank lines at the end are no matter.

    Raises:
        DatasetError: The file is missing, a line is not of the format, or repeats another; the message names the line.
    """
    try:
        with path.open(encoding="utf-8-sig") as file:
            rows = _read_rows(file, path)
    except (OSError, UnicodeDecodeError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); make it with warehouse-sim predict") from problem
    _require_one_time(rows, str(path))
    return rows


def _read_rows(file: TextIO, path: Path) -> list[PoseEstimate]:
    header = file.readline(_LONGEST_LINE).rstrip("\n")
    if header.strip() != _HEADER:
        raise DatasetError(f"{path}:1: the header must be {_HEADER!r}, found {shown(header)}")
    rows: dict[tuple[int, int, int, float, bytes, float], int] = {}
    estimates = []
    for number, row in _parsed(_numbered(file, path), path):
        key = (row.scene_id, row.image_id, row.obj_id, row.score, row.T_camera_object.tobytes(), row.time)
        if rows.setdefault(key, number) != number:
            raise DatasetError(f"{path}:{number}: repeats line {rows[key]}; remove one of the two")
        estimates.append(row)
    return estimates


def _parsed(lines: Iterator[tuple[int, str]], path: Path) -> Iterator[tuple[int, PoseEstimate]]:
    """Yield estimates with their line numbers; the poses of many lines are checked at once."""
    while block := list(islice(lines, _AT_ONCE)):
        words = []
        wrong: DatasetError | None = None
        for number, line in block:
            try:
                words.append(_words(line, f"{path}:{number}"))
            except DatasetError as problem:
                # Raised when the lines above it have been looked at.
                wrong = problem
                break
        T_camera_object = _poses(np.array([row[2] for row in words]).reshape(-1, 12))
        unsound = np.flatnonzero(~_sound(T_camera_object))
        if len(unsound):
            number, line = block[unsound[0]]
            raise _problem(line, f"{path}:{number}")
        for (number, _), (ids, score, _, time), T in zip(block, words, T_camera_object, strict=False):
            yield number, PoseEstimate(*ids, score, T, time)
        if wrong is not None:
            raise wrong


def _numbered(file: TextIO, path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines behind the header with their numbers, without the blank ones at the end."""
    blank = 0
    for number, line in enumerate(iter(lambda: file.readline(_LONGEST_LINE + 1), ""), start=2):
        if not line.strip():
            blank = blank or number
        elif blank:
            raise DatasetError(f"{path}:{blank}: the line is blank; only lines at the end may be")
        elif len(line) > _LONGEST_LINE:
            raise DatasetError(
                f"{path}:{number}: has over {_LONGEST_LINE} characters, which no row of a pose CSV needs"
            )
        else:
            yield number, line


def _line(row: PoseEstimate) -> str:
    R = " ".join(map(repr, row.T_camera_object[:3, :3].ravel().tolist()))
    t = " ".join(map(repr, (row.T_camera_object[:3, 3] * 1000.0).tolist()))
    return f"{row.scene_id},{row.image_id},{row.obj_id},{float(row.score)!r},{R},{t},{float(row.time)!r}"


def _words(line: str, where: str) -> tuple[tuple[int, int, int], float, list[float], float]:
    """Return what a line says, R and t in one list."""
    cells = line.strip().split(",")
    if len(cells) != 7:
        raise DatasetError(f"{where}: 7 fields separated by commas are expected, found {len(cells)}")
    ids = _whole(cells[0], where), _whole(cells[1], where), _whole(cells[2], where)
    (score,), R, t_mm, (time,) = (
        _numbers(cell, count, name, where)
        for cell, count, name in zip(cells[3:], (1, 9, 3, 1), ("score", "R", "t", "time"), strict=True)
    )
    return ids, score, R + t_mm, time


def _poses(numbers: Float[np.ndarray, "n 12"]) -> Transforms:
    return make_transform(numbers[:, :9].reshape(-1, 3, 3), numbers[:, 9:] / 1000.0)


def _sound(T_camera_object: Transforms) -> Bool[np.ndarray, " n"]:
    """Return which are rigid and not too far away."""
    near = np.abs(T_camera_object[:, :3, 3]).max(axis=1, initial=0.0) <= _FARTHEST_MM / 1000.0
    R = T_camera_object[:, :3, :3]
    # The entries first: those of a rotation are at most 1, and products of large ones would overflow.
    small = np.abs(R).max(axis=(1, 2), initial=0.0) <= 1.0 + _TOLERANCE
    R = np.where(small[:, None, None], R, 0.0)
    square = np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max(axis=(1, 2), initial=0.0) <= _TOLERANCE
    return near & small & square & (np.linalg.det(R) > 0.0)


def _problem(line: str, where: str) -> DatasetError:
    """Return what is wrong with the pose of a line."""
    _, _, numbers, _ = _words(line, where)
    if np.abs(numbers[9:]).max() > _FARTHEST_MM:
        found = shown(line.strip().split(",")[5])
        return DatasetError(f"{where}: t is in millimetres and ends at {_FARTHEST_MM:g}, found {found}")
    return DatasetError(f"{where}: R must be a rotation, found {numbers[:9]}")


def _whole(cell: str, where: str) -> int:
    digits = cell.strip()
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 18):
        raise DatasetError(f"{where}: scene_id, im_id and obj_id are whole numbers, found {shown(cell)}")
    return int(digits)


def _numbers(cell: str, count: int, name: str, where: str) -> list[float]:
    try:
        numbers = [decimal(word) for word in cell.split()]
    except ValueError:
        raise DatasetError(f"{where}: {name} holds something else than numbers: {shown(cell)}") from None
    if len(numbers) != count:
        wanted = "one number" if count == 1 else f"{count} numbers separated by spaces"
        raise DatasetError(f"{where}: {name} needs {wanted}, found {len(numbers)}")
    if not all(map(isfinite, numbers)):
        raise DatasetError(f"{where}: {name} must be finite, found {shown(cell)}")
    return numbers


def _require_one_time(rows: list[PoseEstimate], where: str) -> None:
    times: dict[tuple[int, int], float] = {}
    for row in rows:
        if times.setdefault((row.scene_id, row.image_id), row.time) != row.time:
            raise DatasetError(f"{where}: time is that of a whole image, but the rows of {_image(row)} differ")


def _image(row: PoseEstimate) -> str:
    return f"scene {row.scene_id}, image {row.image_id}"
