"""The BOP pose CSV: ``scene_id,im_id,obj_id,score,R,t,time`` with R row-major and t in millimetres."""

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.atomic import write_bytes
from warehouse_sim.dataset.plain import is_rigid
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import PoseEstimate

_HEADER = "scene_id,im_id,obj_id,score,R,t,time"
# A file from elsewhere may hold rotations of few digits.
_ROTATION_TOLERANCE = 1e-2


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
    path.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(path, ("\n".join(lines) + "\n").encode("ascii"), durable=True)


def read(path: Path) -> list[PoseEstimate]:
    """Read estimates in file order.

    Raises:
        DatasetError: The file is missing, or a line is not of the format; the message names file and line.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); make it with warehouse-sim predict") from problem
    if not lines or lines[0].strip() != _HEADER:
        raise DatasetError(f"{path}:1: the header must be {_HEADER!r}, found {lines[0] if lines else '(nothing)'!r}")
    rows = [_parse(line, f"{path}:{number}") for number, line in enumerate(lines[1:], start=2)]
    _require_one_time(rows, str(path))
    return rows


def _line(row: PoseEstimate) -> str:
    R = " ".join(map(repr, row.T_camera_object[:3, :3].ravel().tolist()))
    t = " ".join(map(repr, (row.T_camera_object[:3, 3] * 1000.0).tolist()))
    return f"{row.scene_id},{row.image_id},{row.obj_id},{float(row.score)!r},{R},{t},{float(row.time)!r}"


def _parse(line: str, where: str) -> PoseEstimate:
    cells = line.split(",")
    if len(cells) != 7:
        raise DatasetError(f"{where}: 7 fields separated by commas are expected, found {len(cells)}")
    try:
        scene_id, image_id, obj_id = (int(cell) for cell in cells[:3])
        score, time = float(cells[3]), float(cells[6])
        R, t_mm = (np.array([float(word) for word in cell.split()]) for cell in cells[4:6])
    except ValueError as problem:
        raise DatasetError(f"{where}: a field is not a number ({problem})") from problem
    if R.shape != (9,) or t_mm.shape != (3,):
        raise DatasetError(f"{where}: R needs 9 and t needs 3 numbers, found {R.size} and {t_mm.size}")
    T_camera_object = make_transform(R.reshape(3, 3), t_mm / 1000.0)
    if not (math.isfinite(score) and math.isfinite(time) and is_rigid(T_camera_object, _ROTATION_TOLERANCE)):
        raise DatasetError(f"{where}: R must be a rotation, and every number finite")
    return PoseEstimate(scene_id, image_id, obj_id, score, T_camera_object, time)


def _require_one_time(rows: list[PoseEstimate], where: str) -> None:
    times: dict[tuple[int, int], float] = {}
    for row in rows:
        if times.setdefault((row.scene_id, row.image_id), row.time) != row.time:
            raise DatasetError(f"{where}: time is that of a whole image, but the rows of {_image(row)} differ")


def _image(row: PoseEstimate) -> str:
    return f"scene {row.scene_id}, image {row.image_id}"
