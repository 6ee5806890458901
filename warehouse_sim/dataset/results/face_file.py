"""``NAME.faces.json`` beside ``NAME.csv``: where forks go in, for the rows of a pose CSV that say so.

The CSV stays what BOP defines; tools that know only that never see the faces. Metres and radians; the file names the
CSV's digest, so that faces of other predictions are not taken for these.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.plain import is_rigid
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


def write(poses: Path, estimates: Sequence[PoseEstimate]) -> Path | None:
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
    text = json.dumps({"poses": poses.name, "sha256": _digest(poses), "faces": rows}, indent=1)
    write_bytes(path, (text + "\n").encode("ascii"), durable=True)
    return path


def attach(poses: Path, estimates: Sequence[PoseEstimate]) -> list[PoseEstimate]:
    """Return the rows of a pose CSV with their faces, if a file of those lies beside it.

    Raises:
        DatasetError: The file is not of this format, or not of this CSV.
    """
    path = face_path(poses)
    if not path.is_file():
        return list(estimates)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        digest, rows = content["sha256"], content["faces"]
        placed = [(int(row["row"]), _face(row, f"{path}: faces[{i}]")) for i, row in enumerate(rows)]
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise DatasetError(f"{path}: is no file of faces ({problem!r}); predict again, or remove it") from problem
    if digest != _digest(poses):
        raise DatasetError(f"{path}: belongs to other predictions than {poses}; predict again, or remove it")
    found = list(estimates)
    for index, face in placed:
        if not 0 <= index < len(found):
            raise DatasetError(f"{path}: row {index} is not in {poses}, which has {len(found)} rows; predict again")
        found[index] = replace(found[index], face=face)
    return found


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _row(index: int, item: PoseEstimate) -> dict[str, Any]:
    face = item.face
    assert face is not None
    numbers = {name: np.asarray(getattr(face, name), dtype=float) for name in _SHAPES}
    for name, values in numbers.items():
        if not np.isfinite(values).all():
            raise DatasetError(f"the face of row {index}: {name} is not finite")
    # The last four follow from the others, and are what a truck reads.
    told = {
        "direction": face.direction,
        "direction_covariance": face.direction_covariance,
        "pocket_centres": face.pocket_centres,
        "pocket_centres_covariance": face.pocket_centres_covariance,
    }
    places = {"row": index, "scene_id": item.scene_id, "im_id": item.image_id, "detection": item.detection}
    return places | {name: values.tolist() for name, values in (numbers | told).items()}


def _face(row: dict[str, Any], where: str) -> PalletFace:
    count = len(row["pockets"])
    numbers: dict[str, np.ndarray] = {}
    for name, shape in _SHAPES.items():
        values = np.array(row[name], dtype=float)
        wanted = tuple(count if size == "p" else size for size in shape)
        if values.shape != wanted or not np.isfinite(values).all():
            raise DatasetError(f"{where}.{name}: must be finite numbers of shape {wanted}, found {values.shape}")
        numbers[name] = values
    if not is_rigid(numbers["T_camera_dock"], 1e-4):
        raise DatasetError(f"{where}.T_camera_dock: must be a rigid transform")
    covariance = numbers["covariance"]
    if np.abs(covariance - covariance.T).max() > _SYMMETRIC * max(np.abs(covariance).max(), 1e-12):
        raise DatasetError(f"{where}.covariance: must be symmetric")
    return PalletFace(**numbers)
