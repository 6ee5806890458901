"""Key points of a pallet's face: where they are on the object, and how they are read off maps of their places."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import Pocket

POINTS = 6
"""Corners top left, top right, bottom right, bottom left, as seen from before the side; left and right pocket."""
MIRRORED = (1, 0, 3, 2, 5, 4)
"""Which point takes the place of each in the mirror."""
_SIDES: dict[str, tuple[float, float]] = {"-x": (-1, 0), "+x": (1, 0), "-y": (0, -1), "+y": (0, 1)}


def side_points(
    size: Float[np.ndarray, " 3"], pockets: Sequence[Pocket], face: str
) -> tuple[Float[np.ndarray, "6 3"], Bool[np.ndarray, " 6"]]:
    """Return the key points of a side (m, object frame), and which of them there are.

    Args:
        size: Outer edge lengths (m); the origin is in the middle.
        pockets: Those of the object; of a side with more or fewer than two, no centre is a key point.
        face: Name of the side.
    """
    outward = np.array([*_SIDES[face], 0.0])
    # Who stands before it and looks at it has this to the right: up x outward.
    right = np.cross([0.0, 0.0, 1.0], outward)
    half_width, half_height = float(np.abs(right) @ size) / 2.0, float(size[2]) / 2.0
    middle = outward * float(np.abs(outward) @ size) / 2.0
    up = np.array([0.0, 0.0, half_height])
    corners = [middle + sign * half_width * right + lift * up for sign, lift in ((-1, 1), (1, 1), (1, -1), (-1, -1))]
    openings = [pocket.T_object_pocket[:3, 3] for pocket in pockets if pocket.face == face]
    openings.sort(key=lambda point: float(point @ right))
    known = np.array([True] * 4 + [len(openings) == 2] * 2)
    return np.array([*corners, *(openings if len(openings) == 2 else [middle, middle])]), known


def pocket_faces(pockets: Sequence[Pocket]) -> list[str]:
    """Return the sides that pockets open on, sorted."""
    return sorted({pocket.face for pocket in pockets})


def face_points(
    size: Float[np.ndarray, " 3"], pockets: Sequence[Pocket], T_camera_object: Transform
) -> tuple[Float[np.ndarray, "6 3"], Bool[np.ndarray, " 6"]] | None:
    """Return the key points (m, camera frame) of the side with pockets that faces the camera most; None without one."""
    eye = invert(T_camera_object)[:3, 3]
    best, most = None, 0.0
    for face in pocket_faces(pockets):
        points, known = side_points(size, pockets, face)
        middle = points[:4].mean(axis=0)
        towards = eye - middle
        cosine = float(np.array([*_SIDES[face], 0.0]) @ towards / max(np.linalg.norm(towards), 1e-9))
        if cosine > most:
            best, most = (transform_points(T_camera_object, points), known), cosine
    return best


_REACH = 3
"""Pixels about the highest one that say where between pixels a point is."""


class Peaks(NamedTuple):
    """Key points of some crops."""

    uv: Float[np.ndarray, "b k 2"]
    """Places (px)."""
    chance: Float[np.ndarray, "b k"]
    """How much of the map lies about the place, 0-1."""


def find_peaks(logits: Float[Tensor, "b k h w"]) -> Peaks:
    """Return the centre of what lies about the highest place of each map."""
    batch, count, height, width = logits.shape
    chance = torch.softmax(logits.flatten(2), dim=2).view(batch, count, height, width).cpu().numpy().astype(float)
    uv, total = np.zeros((batch, count, 2)), np.zeros((batch, count))
    for i in range(batch):
        for k in range(count):
            row, column = divmod(int(chance[i, k].argmax()), width)
            top, left = max(0, row - _REACH), max(0, column - _REACH)
            part = chance[i, k, top : row + _REACH + 1, left : column + _REACH + 1]
            mass = max(float(part.sum()), 1e-12)
            rows, columns = np.indices(part.shape)
            uv[i, k] = left + (columns * part).sum() / mass, top + (rows * part).sum() / mass
            total[i, k] = mass
    return Peaks(uv, np.minimum(total, 1.0))
