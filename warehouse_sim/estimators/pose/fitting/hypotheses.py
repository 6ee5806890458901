"""Which points of a detection are its object's, and where a box of known size stands upright about them.

Seen from above the points lie on one or two sides of a rectangle. Its direction is the one in which they are nearest to
the sides of their bounding rectangle (the closeness of Zhang et al., "Efficient L-shape fitting for vehicle detection
using laser scanners", IV 2017); its near corner stays, its size is that of the object.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pipeline import Proposals
from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup

_DIRECTIONS = 45
"""Directions that are tried in a quarter turn."""
_OUTER = 0.02
"""This quantile and its opposite stand for the border of a set of points: some readings lie between two surfaces."""
_WHOLE = 0.8
"""Fraction of the height from which all of it counts as seen."""
_TOO_LONG = 1.2
"""Points that reach so many times the length of a side are of more than one object."""
_LEAST_DISTANCE = 0.01
"""Nearer to a side (m) than this, all points count the same."""


@dataclass(frozen=True, eq=False)
class _Rectangle:
    """A rectangle about points seen from above, in the upright frame."""

    yaw: float
    """Direction of its first side (rad)."""
    low: Float[np.ndarray, " 2"]
    """Least coordinates along its sides (m)."""
    high: Float[np.ndarray, " 2"]
    """Greatest ones."""


def upright_boxes(points: Float[np.ndarray, "n 3"], size: Float[np.ndarray, " 3"]) -> Transforms:
    """Return the upright poses ``T_upright_object`` of a box that go with points of its surface, "h 4 4".

    The sides that face the sensor, which is at the origin, touch the points; which of the box's sides is which, nobody
    knows yet: the poses are quarter turns apart. Where less than most of its height is seen, the points may be its
    lower or its upper part, and there are poses for both. Where the points reach farther than the box, some are of its
    neighbours, and there are poses at either end.

    Args:
        points: In a frame with z up and the sensor at its origin (m).
        size: Edge lengths of the box (m).
    """
    found = _fit_rectangle(points[:, :2])
    low, high = quantiles(points[:, 2], _OUTER)
    heights = [(low + high) / 2.0]
    # What stands on the object hides its top, the image's border its foot; a neighbour above or below adds to it.
    if not _WHOLE * size[2] <= high - low <= _TOO_LONG * size[2]:
        heights += [low + size[2] / 2.0, high - size[2] / 2.0]
    if high - low < _WHOLE * size[2]:
        heights = heights[1:]
    centres = [(quarter, centre) for quarter in range(4) for centre in _centres(found, size, quarter)]
    return np.stack([_placed(found, centre, height, quarter) for height in heights for quarter, centre in centres])


def _fit_rectangle(points: Float[np.ndarray, "n 2"]) -> _Rectangle:
    step = np.pi / 2.0 / _DIRECTIONS
    coarse = np.arange(_DIRECTIONS) * step
    finer = coarse[_closeness(points, coarse).argmax()] + np.linspace(-step, step, 9)
    yaw = float(finer[_closeness(points, finer).argmax()])
    low, high = quantiles((points @ _axes(yaw)).T, _OUTER)
    return _Rectangle(yaw, low, high)


def _closeness(points: Float[np.ndarray, "n 2"], yaws: Float[np.ndarray, " d"]) -> Float[np.ndarray, " d"]:
    """Return how near to the sides of their rectangle the points lie, for each of some directions."""
    along = np.stack([_axes(float(yaw)).T for yaw in yaws]) @ points.T
    low, high = quantiles(along, _OUTER)
    inside = np.minimum(np.abs(along - low[..., None]), np.abs(high[..., None] - along)).min(axis=1)
    return (1.0 / np.maximum(inside, _LEAST_DISTANCE)).sum(axis=1)


def _centres(found: _Rectangle, size: Float[np.ndarray, " 3"], quarter: int) -> list[Float[np.ndarray, " 2"]]:
    """Return where the box's centre may be, along the rectangle's sides, if its x axis is ``quarter`` turns away."""
    sides = size[:2] if quarter % 2 == 0 else size[1::-1]
    middle = (found.low + found.high) / 2.0
    seen = found.high - found.low
    # The near sides, those on the sensor's side of the middle, are where the points begin; the far ones follow from the
    # size. Along a side that is seen from end to end the middle is surer than either end.
    near = np.where(middle > 0.0, found.low, found.high)
    centre = near + np.sign(middle) * sides / 2.0
    centre = np.where(np.abs(seen - sides) <= 0.15 * sides, middle, centre)
    centres = [centre]
    for axis in np.flatnonzero(seen > _TOO_LONG * sides):
        ends = found.low[axis] + sides[axis] / 2.0, found.high[axis] - sides[axis] / 2.0
        centres = [np.where(np.arange(2) == axis, end, one) for one in centres for end in ends]
    return centres


def _placed(found: _Rectangle, centre: Float[np.ndarray, " 2"], centre_z: float, quarter: int) -> Transform:
    """Return the pose whose x axis is ``quarter`` quarter turns from the rectangle's first side."""
    place = _axes(found.yaw) @ centre
    return make_transform(rotation_z(found.yaw + quarter * np.pi / 2.0), np.array([*place, centre_z]))


def _axes(yaw: float) -> Float[np.ndarray, "2 2"]:
    """Return the directions of a rectangle's sides as columns."""
    return np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])


def quantiles(
    values: Float[np.ndarray, "*batch n"], fraction: float
) -> tuple[Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"]]:
    """Return the quantiles ``fraction`` and ``1 - fraction`` of the last axis, linear as numpy's default.

    Args:
        values: At least one a row.
        fraction: 0-0.5.
    """
    ordered = np.sort(values, axis=-1)
    last = ordered.shape[-1] - 1
    low = int(fraction * last)
    part = fraction * last - low
    high, inner = last - low, min(low + 1, last)
    return (
        ordered[..., low] + part * (ordered[..., inner] - ordered[..., low]),
        ordered[..., high] + part * (ordered[..., last - inner] - ordered[..., high]),
    )


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
