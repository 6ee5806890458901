"""The BOP pose CSV: ``scene_id,im_id,obj_id,score,R,t,time`` with R row-major and t in millimetres."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TextIO

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.files.plain import is_rigid
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import PoseEstimate

_HEADER = "scene_id,im_id,obj_id,score,R,t,time"
# A file from elsewhere may hold rotations of few digits.
_ROTATION_TOLERANCE = 1e-2
# In characters; a row with all digits of its numbers has about 350. What is no CSV may have no line end at all.
_LONGEST_LINE = 4096
_FARTHEST_MM = 1e7


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
        raise DatasetError(f"{path}:1: the header must be {_HEADER!r}, found {_shown(header) or '(nothing)'!r}")
    rows: dict[tuple[int, int, int, float, bytes, float], int] = {}
    estimates = []
    for number, line in _numbered(file, path):
        row = _parse(line, f"{path}:{number}")
        key = (row.scene_id, row.image_id, row.obj_id, row.score, row.T_camera_object.tobytes(), row.time)
        if rows.setdefault(key, number) != number:
            raise DatasetError(f"{path}:{number}: repeats line {rows[key]}; remove one of the two")
        estimates.append(row)
    return estimates


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


def _parse(line: str, where: str) -> PoseEstimate:
    cells = line.strip().split(",")
    if len(cells) != 7:
        raise DatasetError(f"{where}: 7 fields separated by commas are expected, found {len(cells)}")
    scene_id, image_id, obj_id = (_whole(cell, where) for cell in cells[:3])
    (score,), R, t_mm, (time,) = (
        _numbers(cell, count, name, where)
        for cell, count, name in zip(cells[3:], (1, 9, 3, 1), ("score", "R", "t", "time"), strict=True)
    )
    if np.abs(t_mm).max() > _FARTHEST_MM:
        raise DatasetError(f"{where}: t is in millimetres and ends at {_FARTHEST_MM:g}, found {_shown(cells[5])!r}")
    T_camera_object = make_transform(R.reshape(3, 3), t_mm / 1000.0)
    # The entries first: those of a rotation are at most 1, and products of large ones would overflow.
    if np.abs(R).max() > 1.0 + _ROTATION_TOLERANCE or not is_rigid(T_camera_object, _ROTATION_TOLERANCE):
        raise DatasetError(f"{where}: R must be a rotation, found {R.tolist()}")
    return PoseEstimate(scene_id, image_id, obj_id, float(score), T_camera_object, float(time))


def _whole(cell: str, where: str) -> int:
    if not re.fullmatch(r"\s*[0-9]{1,18}\s*", cell, re.ASCII):
        raise DatasetError(f"{where}: scene_id, im_id and obj_id are whole numbers, found {_shown(cell)!r}")
    return int(cell)


def _numbers(cell: str, count: int, name: str, where: str) -> Float[np.ndarray, " count"]:
    try:
        numbers = np.array([float(word) for word in cell.split()])
    except ValueError:
        raise DatasetError(f"{where}: {name} holds something else than numbers: {_shown(cell)!r}") from None
    if len(numbers) != count:
        wanted = "one number" if count == 1 else f"{count} numbers separated by spaces"
        raise DatasetError(f"{where}: {name} needs {wanted}, found {len(numbers)}")
    if not np.isfinite(numbers).all():
        raise DatasetError(f"{where}: {name} must be finite, found {_shown(cell)!r}")
    return numbers


def _shown(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."


def _require_one_time(rows: list[PoseEstimate], where: str) -> None:
    times: dict[tuple[int, int], float] = {}
    for row in rows:
        if times.setdefault((row.scene_id, row.image_id), row.time) != row.time:
            raise DatasetError(f"{where}: time is that of a whole image, but the rows of {_image(row)} differ")


def _image(row: PoseEstimate) -> str:
    return f"scene {row.scene_id}, image {row.image_id}"
