"""Which points of a detection are its object's, as far as whoever proposed the poses can tell."""

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pipeline import Proposals
from warehouse_sim.estimators.pose.fitting.rectangle import upright_boxes
from warehouse_sim.geometry.pose import Transforms, make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup

LEAST_POINTS = 32
"""Of fewer points nothing is estimated; with fewer that are trusted, all are taken."""


def own_of(proposals: Proposals, row: int, points: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, " p"]:
    """Return which points (camera frame, m) of object ``row`` to look at.

    Masks may hold other things, boxes always do. Proposals say so by ``trusted``.
    """
    own = proposals.trusted(row, points)
    return own if own.sum() >= LEAST_POINTS else np.ones(len(points), dtype=bool)


_POINTS = 1500
_RECTANGLE_POINTS = 400
"""Points that a rectangle is put around; more do not place it better."""


def masked_points(
    image: RgbdImage, mask: Bool[np.ndarray, "h w"], rng: np.random.Generator
) -> Float[np.ndarray, "p 3"]:
    """Return points of a mask (camera frame, m), 1,500 at most, in random order."""
    u, v = (values[:_POINTS] for values in image.readings_in(mask, rng))
    return image.camera.rays_at(u, v) * image.depth[v, u][:, None].astype(float)


def within_reach(points: Float[np.ndarray, "p 3"], diameter: float) -> Float[np.ndarray, "p 3"]:
    """Leave out points that cannot be of one object with the middle ones."""
    middle = np.median(points, axis=0)
    near = np.linalg.norm(points - middle, axis=1) <= diameter
    return points[near] if near.sum() >= LEAST_POINTS else points


def hypotheses(
    points: Float[np.ndarray, "p 3"], size: Float[np.ndarray, " 3"], down: Float[np.ndarray, " 3"]
) -> Transforms:
    """Return upright poses ``T_camera_object`` that the rectangle about these points may have, (h 4 4).

    Args:
        points: Of the object's surface (camera frame, m), in random order.
        size: Edge lengths of its box (m).
        down: Unit vector of gravity (camera frame).
    """
    T_camera_upright = make_transform(upright_frame(down), np.zeros(3))
    return T_camera_upright @ upright_boxes(points[:_RECTANGLE_POINTS] @ T_camera_upright[:3, :3], size)


def distinct(
    T_camera_object: Transforms, symmetry: SymmetryGroup, turn: float = 0.1, shift: float = 0.05
) -> Transforms:
    """Return the poses without those that look like an earlier one within ``turn`` (rad) and ``shift`` (m)."""
    alike = look_alike(T_camera_object, T_camera_object, symmetry, turn, shift)
    kept = list[int]()
    for number, row in enumerate(alike):
        if not row[kept].any():
            kept.append(number)
    return T_camera_object[kept]


def look_alike(
    T_camera_object: Transforms, others: Transforms, symmetry: SymmetryGroup, turn: float, shift: float
) -> Bool[np.ndarray, "a b"]:
    """Return which of a poses look like which of b others within ``turn`` (rad) and ``shift`` (m)."""
    looks = T_camera_object[:, None] @ symmetry.transforms
    away = np.linalg.norm(looks[:, :, None, :3, 3] - others[:, :3, 3], axis=-1)
    trace = np.einsum("agij,bij->agb", looks[..., :3, :3], others[:, :3, :3])
    same: Bool[np.ndarray, "a b"] = ((away <= shift) & ((trace - 1.0) / 2.0 >= np.cos(turn))).any(axis=1)
    return same
