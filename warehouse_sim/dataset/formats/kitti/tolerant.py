"""KITTI text files of any origin, read as widely as they occur.

Real ones end in blank lines, name their keys in any order, write numbers in any notation, and result files have a
score as a sixteenth field.
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.files.plain import LENGTHS, NUMBERS, PLACES, decimal, nearest_rotation
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.pose import Transform, make_transform

_FIELDS = (15, 16)
_LARGEST_FILE = 16_000_000
"""Bytes of a text file; a label of a thousand objects has a hundredth of it."""
_SAME_KEYS = {"R_rect": "R0_rect", "Tr_velo_cam": "Tr_velo_to_cam", "Tr_imu_velo": "Tr_imu_to_velo"}
"""Names that KITTI's tracking benchmark has for the same matrices."""
_SHAPES = {"P2": (3, 4), "R0_rect": (3, 3), "Tr_velo_to_cam": (3, 4), "D_02": (1, 5), "F_02": (1, 4)}
"""What is needed of a calib file, and the shapes; all other lines are left alone."""
OUR_SHAPES = (
    dict.fromkeys(("P0", "P1", "P2", "P3"), (3, 4))
    | {"R0_rect": (3, 3), "Tr_velo_to_cam": (3, 4), "Tr_imu_to_velo": (3, 4)}
    | {f"{key}_{eye}": shape for eye in ("02", "03") for key, shape in (("K", (3, 3)), ("D", (1, 5)), ("F", (1, 4)))}
)
"""All that a calib file of this package can hold."""


def read_text(path: Path) -> str:
    """Read a text file.

    Raises:
        DatasetError: It cannot be read, is no text, or is far too large.
    """
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise DatasetError(f"{path}: has more than {_LARGEST_FILE} bytes; a KITTI text file is a few kilobytes")
        return path.read_bytes().decode("utf-8")
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror}); copy the frame again") from problem
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{path}: is no text ({problem.reason}); copy the file again") from problem


def read_labels(text: str, where: str) -> list[KittiLabel]:
    """Return every row of a label or result file in order, DontCare included; blank lines are none.

    Raises:
        DatasetError: A row has another number of fields, or a field is no number or out of range.
    """
    lines = [(number, line.split()) for number, line in enumerate(text.splitlines(), start=1)]
    return [_label(words, f"{where}:{number}") for number, words in lines if words]


def read_matrices(
    text: str, where: str, shapes: Mapping[str, tuple[int, int]]
) -> dict[str, Float[np.ndarray, "rows columns"]]:
    """Return the matrices of ``shapes`` that a file of lines ``KEY: v v ...`` holds, in its order.

    Raises:
        DatasetError: One of them has another number of values or one that is no number.
    """
    found: dict[str, Float[np.ndarray, "rows columns"]] = {}
    for line in text.splitlines():
        words = line.replace(":", " ", 1).split()
        key = _SAME_KEYS.get(words[0], words[0]) if words else ""
        if key in shapes:
            found[key] = _numbers(words[1:], f"{where}: {key}", math.prod(shapes[key])).reshape(shapes[key])
    return found


def read_calib(text: str, where: str) -> dict[str, Float[np.ndarray, "rows columns"]]:
    """Return the matrices of a calib file that say where everything is.

    Raises:
        DatasetError: As ``read_matrices``, or P2 is missing.
    """
    found = read_matrices(text, where, _SHAPES)
    if "P2" not in found:
        raise DatasetError(f"{where}: has no line P2; the camera of image_2 must be known")
    return found


def rigid(rows: Float[np.ndarray, "3 columns"], where: str) -> Transform:
    """Return the transform of a rotation (3 x 3) or a pose (3 x 4) whose numbers were rounded.

    Raises:
        DatasetError: It is far from any rotation, or leads too far away.
    """
    translation = rows[:, 3] if rows.shape[1] > 3 else np.zeros(3)
    if not all(value in PLACES for value in translation):
        raise DatasetError(f"{where}: must lead {PLACES} m along each axis, found {translation.tolist()}")
    return make_transform(nearest_rotation(rows[:, :3], f"{where}:"), translation)


def read_plane(text: str, where: str) -> Float[np.ndarray, " 4"]:
    """Return a, b, c, d of the floor a x + b y + c z + d = 0 in the rectified frame, with |(a, b, c)| = 1 and b < 0.

    Raises:
        DatasetError: The last line is not four numbers, or they are no plane that lies below the camera.
    """
    rows = [line.split() for line in text.splitlines() if line.strip()]
    plane = _numbers(rows[-1] if rows else [], where, 4)
    length = float(np.linalg.norm(plane[:3]))
    if length == 0.0 or plane[1] == 0.0:
        raise DatasetError(f"{where}: {plane.tolist()} is no floor; delete the file if the frame has none")
    return plane / (-math.copysign(length, plane[1]))


def has_box(label: KittiLabel) -> bool:
    """Return whether a row describes a 3D box; DontCare and results of 2D detectors do not."""
    return not label.is_dont_care and all(edge in LENGTHS for edge in label.size_hwl)


def _label(words: list[str], where: str) -> KittiLabel:
    if len(words) not in _FIELDS:
        raise DatasetError(f"{where}: a KITTI label has 15 fields, a result 16; found {len(words)}")
    values = _numbers(words[1:], where, len(words) - 1).tolist()
    return KittiLabel.of(words[0], int(values[1]), [values[0], *values[2:14]])


def _numbers(words: list[str], where: str, count: int) -> Float[np.ndarray, " count"]:
    try:
        values = np.array([decimal(word) for word in words])
    except ValueError as problem:
        raise DatasetError(f"{where}: expected {count} numbers, found a word ({problem})") from problem
    if values.size != count or not all(value in NUMBERS for value in values):
        raise DatasetError(f"{where}: expected {count} numbers, each {NUMBERS}, found {shown(' '.join(words))}")
    return values
