"""A file of predictions: the BOP pose CSV, and beside it, in JSON, what that has no column for.

``NAME.csv`` holds what an estimator answers for; ``NAME.uncertainty.json`` the covariance and the errors that it
expects of each row, and the estimates that it rejected, which no row has: who reads the CSV alone never sees them.
``NAME.faces.json`` has the faces of the estimates that have any. ``NAME.origin.json`` says what predicted.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.checksums import file_sum
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.plain import WHOLE, Span, is_rigid, take, take_if_given, take_numbers
from warehouse_sim.dataset.results import pose_csv
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import write_bytes
from warehouse_sim.schema import PalletFace, PoseEstimate

_SHAPES: dict[str, tuple[int | str, ...]] = {
    "T_camera_dock": (4, 4),
    "covariance": (6, 6),
    "pockets": ("p", 2),
    "pockets_covariance": ("p", 2, 2),
    "pocket_sizes": ("p", 2),
    "pocket_sizes_covariance": ("p", 2, 2),
    "size": (2,),
    "size_covariance": (2, 2),
}
_SYMMETRIC = 1e-6
"""Largest relative difference of a covariance from its transpose."""


def face_path(poses: Path) -> Path:
    """Return where the faces of a pose CSV are."""
    return poses.with_suffix(".faces.json")


def write_faces(poses: Path, estimates: Sequence[PoseEstimate]) -> Path | None:
    """Write the faces of a pose CSV that is written already, and return where; None, and no file, if there are none.

    Args:
        poses: The CSV.
        estimates: Its rows.
    """
    path = face_path(poses)
    rows = [_row(index, item) for index, item in enumerate(estimates) if item.face is not None]
    if not rows:
        path.unlink(missing_ok=True)
        return None
    text = json.dumps({"poses": poses.name, "sha256": file_sum(poses), "faces": rows}, indent=1)
    write_bytes(path, (text + "\n").encode("ascii"), durable=True)
    return path


def attach_faces(poses: Path, estimates: Sequence[PoseEstimate]) -> list[PoseEstimate]:
    """Return the rows of a pose CSV with their faces, if a file of those lies beside it.

    Raises:
        DatasetError: The file is not of this format, or not of this CSV.
    """
    path = face_path(poses)
    if not path.is_file():
        return list(estimates)
    data, found = read_json(path), list(estimates)
    if take(data, "sha256", str, str(path)) != file_sum(poses):
        raise DatasetError(f"{path}: belongs to other predictions than {poses}; predict again, or remove it")
    for number, row in enumerate(take(data, "faces", list, str(path))):
        where = f"{path}: faces[{number}]"
        index = take(row, "row", int, where, WHOLE)
        if index >= len(found):
            raise DatasetError(f"{path}: row {index} is not in {poses}, which has {len(found)} rows; predict again")
        found[index] = replace(found[index], face=_face(row, where))
    return found


def _row(index: int, item: PoseEstimate) -> dict[str, Any]:
    face = item.face
    assert face is not None
    numbers = {name: np.asarray(getattr(face, name), dtype=float) for name in _SHAPES}
    for name, values in numbers.items():
        if not np.isfinite(values).all():
            raise DatasetError(f"the face of row {index}: {name} is not finite")
    # The last four follow from the others, and are what a truck reads.
    derived = {
        "direction": face.direction,
        "direction_covariance": face.direction_covariance,
        "pocket_centres": face.pocket_centres,
        "pocket_centres_covariance": face.pocket_centres_covariance,
    }
    places = {"row": index, "scene_id": item.scene_id, "im_id": item.image_id, "detection": item.detection}
    return places | {name: values.tolist() for name, values in (numbers | derived).items()}


def _face(row: dict[str, Any], where: str) -> PalletFace:
    count = len(take(row, "pockets", list, where))
    numbers: dict[str, np.ndarray] = {}
    for name, shape in _SHAPES.items():
        wanted = tuple(count if size == "p" else size for size in shape)
        try:
            values = np.array(take(row, name, list, where), dtype=float)
        except (ValueError, TypeError) as problem:
            raise DatasetError(f"{where}.{name}: must be numbers of shape {wanted} ({problem})") from problem
        if values.shape != wanted or not np.isfinite(values).all():
            raise DatasetError(f"{where}.{name}: must be finite numbers of shape {wanted}, found {values.shape}")
        numbers[name] = values
    if not is_rigid(numbers["T_camera_dock"], 1e-4):
        raise DatasetError(f"{where}.T_camera_dock: must be a rigid transform")
    covariance = numbers["covariance"]
    if np.abs(covariance - covariance.T).max() > _SYMMETRIC * max(np.abs(covariance).max(), 1e-12):
        raise DatasetError(f"{where}.covariance: must be symmetric")
    return PalletFace(**numbers)


_FORMAT = 1
_ORDER = ["x", "y", "z", "about x", "about y", "about z"]
_UPPER = np.triu_indices(6)
_ERROR = Span(0.0, pose_csv.FARTHEST_ERROR)


def uncertainty_file(path: Path) -> Path:
    """Return the file that goes with a pose CSV."""
    return path.with_suffix(".uncertainty.json")


@dataclass(frozen=True)
class Origin:
    """What made a file of predictions."""

    method: str
    """Name of the estimator."""
    command: str = ""
    """The command that ran it; empty where none did."""


def _origin_file(path: Path) -> Path:
    return path.with_suffix(".origin.json")


def origin(path: Path) -> Origin | None:
    """Return what made a pose CSV; None where that is not stated, or is of another CSV that had this name.

    Raises:
        DatasetError: The file beside it is malformed.
    """
    beside = _origin_file(path)
    if not beside.is_file():
        return None
    data, where = read_json(beside), str(beside)
    if take(data, "csv_sha256", str, where) != file_sum(path):
        return None
    return Origin(take(data, "method", str, where), take(data, "command", str, where))


def write(path: Path, estimates: Sequence[PoseEstimate], made_by: Origin | None = None) -> None:
    """Write estimates: those that are not rejected as a pose CSV, what is thought of all beside it.

    Where nothing is thought of any, an older file beside it is removed; likewise where it is not said what predicted.

    Raises:
        DatasetError: A value is not finite, or the rows of one image differ in time.
    """
    given = [item for item in estimates if not item.rejected]
    rejected = [item for item in estimates if item.rejected]
    pose_csv.write(path, given)
    write_faces(path, given)
    if made_by is None:
        _origin_file(path).unlink(missing_ok=True)
    else:
        write_json(_origin_file(path), {"csv_sha256": file_sum(path), **asdict(made_by)})
    rows = {row: _plain(item) for row, item in enumerate(given)}
    known = [{"row": row, **plain} for row, plain in rows.items() if plain]
    if not known and not rejected:
        uncertainty_file(path).unlink(missing_ok=True)
        return
    data = {
        "format": _FORMAT,
        "csv_sha256": file_sum(path),
        "covariance": {
            "order": _ORDER,
            "units": "m, rad",
            "frame": "axes of the camera (x right, y down, z forward), about the object's origin",
            "stored": "upper triangle, row by row",
        },
        "rows": known,
        "rejected": [_rejected(item) for item in rejected],
    }
    write_json(uncertainty_file(path), data, depth=2)


def read(path: Path) -> list[PoseEstimate]:
    """Read the estimates of a pose CSV with what stands beside it; rejected ones are left out.

    Raises:
        DatasetError: A file is malformed, or the one beside it belongs to another CSV.
    """
    estimates = list(attach_faces(path, pose_csv.read(path)))
    beside = uncertainty_file(path)
    if not beside.is_file():
        return estimates
    data = _checked(beside, path)
    for entry in take(data, "rows", list, str(beside)):
        where = f"{beside}: rows"
        row = take(entry, "row", int, where, WHOLE)
        if row >= len(estimates):
            raise DatasetError(f"{where}: there is no row {row} in {path}, which has {len(estimates)}; predict again")
        estimates[row] = _with_uncertainty(estimates[row], entry, f"{where}: {row}")
    return estimates


def count_rejected(path: Path) -> int:
    """Return how many estimates were rejected when a pose CSV was written.

    Raises:
        DatasetError: As ``read``.
    """
    beside = uncertainty_file(path)
    return len(take(_checked(beside, path), "rejected", list, str(beside))) if beside.is_file() else 0


def _checked(beside: Path, path: Path) -> Any:
    data = read_json(beside)
    found = data.get("format") if isinstance(data, dict) else None
    if found != _FORMAT:
        raise DatasetError(f"{beside}: is of format {found}, not {_FORMAT}; predict again, or remove it")
    if take(data, "csv_sha256", str, str(beside)) != file_sum(path):
        raise DatasetError(
            f"{beside}: belongs to another {path.name} than the one beside it; remove it to go on without"
        )
    return data


def _plain(item: PoseEstimate) -> dict[str, Any]:
    errors = {"predicted_error": item.predicted_error, "error_bound": item.error_bound}
    plain: dict[str, Any] = {key: float(value) for key, value in errors.items() if value is not None}
    if item.covariance is not None:
        plain["covariance"] = np.asarray(item.covariance)[_UPPER].tolist()
    return plain


def _rejected(item: PoseEstimate) -> dict[str, Any]:
    """Return what is kept of a rejected estimate, so that it can be looked at."""
    return {
        "scene_id": item.scene_id,
        "im_id": item.image_id,
        "obj_id": item.obj_id,
        "T_camera_object": np.asarray(item.T_camera_object).tolist(),
        **_plain(item),
    }


def _with_uncertainty(item: PoseEstimate, entry: Any, where: str) -> PoseEstimate:
    covariance = None
    if "covariance" in entry:
        covariance = np.zeros((6, 6))
        covariance[_UPPER] = take_numbers(entry, "covariance", len(_UPPER[0]), where)
        covariance = covariance + np.triu(covariance, 1).T
        if np.linalg.eigvalsh(covariance).min() < -1e-9:
            raise DatasetError(f"{where}: covariance must have no negative variance in any direction; predict again")
    predicted, bound = (take_if_given(entry, key, float, where, _ERROR) for key in ("predicted_error", "error_bound"))
    return replace(item, predicted_error=predicted, error_bound=bound, covariance=covariance)
