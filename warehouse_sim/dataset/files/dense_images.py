"""Directions and positions of every pixel as 16-bit PNG: one number of a channel is one step, 0 0 0 is nothing.

Steps are as fine as 16 bits allow: 3.1e-5 of a unit vector, 1.5e-5 of an edge of an object's box.
"""

import cv2
import numpy as np
from jaxtyping import Float32, UInt16

from warehouse_sim.dataset.files.extent import Source, read_bytes, where_of
from warehouse_sim.dataset.files.png import encode_png, require_whole_png
from warehouse_sim.errors import DatasetError

NORMAL_MIDDLE, NORMAL_STEPS = 32768, 32767
"""What a normal's 0 is stored as, and the steps from there to 1 and to -1."""
COORDINATE_FIRST, COORDINATE_STEPS = 1, 65534
"""What a coordinate's 0 is stored as, and the steps from there to 1."""


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
