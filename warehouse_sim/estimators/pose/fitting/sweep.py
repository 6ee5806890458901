"""Where an object may stand upright: all directions, either end of what is seen, sifted by the depth image.

A rectangle about the points (see ``rectangle``) goes astray where a tenth of them lies between two surfaces, or where
something covers one of its corners. So directions all round are tried, at each of which the object begins, or ends,
where the points do. The depth image says at a few samples of the object's outer sides which of these many go on: those
sides hide nothing of each other, so that one look at all poses together is enough.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.pose.fitting.hypotheses import quantiles
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.estimators.pose.icp.surface import CadSurface, dot
from warehouse_sim.geometry.pose import Transform, Transforms, invert, make_transform, rotation_angle, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup

_GRAZING = 0.1
"""Cosine to the ray below which a sample is not believed to be seen."""
_OUTER = 0.01
"""Samples within so much (m) of the object's box, and facing out of it, are of its outer sides."""
_SAMPLES = 200
_LEAST_SAMPLES = 50
"""With fewer of these on its box an object is no box, and all samples are looked at."""
_EXPLAINED = 100
"""Points of the mask that are tested against the object's box."""

_MOVED_BY = 0.07
"""Standard deviation (m) of how the best poses are moved; a third of it upwards."""
_TURNED_BY = 0.08
"""And turned (rad)."""


DIRECTIONS = 24
"""Directions within what the object's symmetry lets differ."""
_QUANTILE = 0.04
"""Fraction of the points beyond either end of what is seen."""
_TOLERANCE, _TOLERANCE_FRACTION = 0.06, 0.01
"""Within so much (m) of the surface a reading is on it, and what that grows by with the distance."""
_NEAR, _MOVED = 10, 12
"""The best so many poses are tried again, each at so many places around."""
KEPT = 6
"""Poses that go on."""


@dataclass(frozen=True, eq=False)
class Sides:
    """Samples of an object's outer sides."""

    points: Float[np.ndarray, "k 3"]
    normals: Float[np.ndarray, "k 3"]
    size: Float[np.ndarray, " 3"]
    """Edge lengths of its box (m)."""


def outer_sides(surface: CadSurface) -> Sides:
    """Return samples of the sides of an object's box, ``_SAMPLES`` at most."""
    points, normals = surface.points, surface.normals[surface.faces]
    low, high = surface.low, surface.high
    at_side = ((points <= low + _OUTER) & (normals < -0.9)) | ((points >= high - _OUTER) & (normals > 0.9))
    outer = np.flatnonzero(at_side.any(axis=1))
    if len(outer) < _LEAST_SAMPLES:
        outer = np.arange(len(points))
    chosen = outer[np.argsort(surface.rank[outer])[:_SAMPLES]]
    return Sides(points[chosen], normals[chosen], surface.size)


def swept(
    points: Float[np.ndarray, "p 3"],
    sides: Sides,
    symmetry: SymmetryGroup,
    view: DepthView,
    down: Float[np.ndarray, " 3"],
    beside: Transforms | None = None,
) -> Transforms:
    """Return the upright poses ``T_camera_object`` that the depth image speaks for most, the best first, (h 4 4).

    Args:
        points: Of the object's surface (camera frame, m).
        sides: Of the object, the middle of its box at the origin.
        symmetry: Turns about z that look alike are tried once.
        view: The image.
        down: Unit vector of gravity (camera frame).
        beside: Poses (g 4 4) that are sifted with the others.
    """
    T_camera_upright = make_transform(upright_frame(down), np.zeros(3))
    tried = T_camera_upright @ anchored(points @ T_camera_upright[:3, :3], sides.size, _period(symmetry))
    if beside is not None:
        tried = np.concatenate([beside, tried])
    scores = _scores(tried, sides, view)
    best = tried[np.argsort(-scores, kind="stable")[:_NEAR]]
    moved = _moved(best, T_camera_upright).reshape(-1, 4, 4)
    tried = np.concatenate([tried, moved])
    scores = np.concatenate([scores, _scores(moved, sides, view)])
    return _apart(tried[np.argsort(-scores, kind="stable")], symmetry)


def anchored(
    upright: Float[np.ndarray, "p 3"], size: Float[np.ndarray, " 3"], period: float, quantile: float = _QUANTILE
) -> Transforms:
    """Return boxes in all directions that begin or end, along each of their edges, where points do, (h 4 4).

    Args:
        upright: Points in a frame with z up (m).
        size: Edge lengths of the box (m).
        period: Turn about z (rad) after which it looks the same.
        quantile: Fraction of the points beyond either end.
    """
    yaws = np.arange(DIRECTIONS) * (period / DIRECTIONS)
    R = np.stack([rotation_z(yaw) for yaw in yaws])
    along = np.swapaxes(R[:, :, :2], 1, 2) @ upright.T
    ends = np.empty((2, len(yaws), 3))
    ends[..., :2] = quantiles(along, quantile)
    ends[..., 2] = np.array(quantiles(upright[:, 2], quantile))[:, None]
    centres = ends + np.array([0.5, -0.5])[:, None, None] * size
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
    chosen = np.moveaxis(centres[corners, :, np.arange(3)], 2, 0)
    turned = np.broadcast_to(R[:, None], (*chosen.shape, 3))
    T: Transforms = make_transform(turned, chosen @ np.swapaxes(R, 1, 2))
    return T.reshape(-1, 4, 4)


def _period(symmetry: SymmetryGroup) -> float:
    """Return the turn about z (rad) after which an object looks the same."""
    about_z = symmetry.transforms[:, 2, 2] > 0.999
    return float(2.0 * np.pi / max(int(about_z.sum()), 1))


def _scores(T_camera_object: Transforms, sides: Sides, view: DepthView) -> Float[np.ndarray, " h"]:
    """Return gains less prices of each pose, as ``verification.judge`` weighs them, but for what covers itself."""
    pose, points, cosine = _facing(T_camera_object, sides)
    u, v = np.rint(view.camera.project(points)).astype(np.int64).T
    height, width = view.depth.shape
    inside = np.flatnonzero((u >= 0) & (u < width) & (v >= 0) & (v < height))
    pose, z, cosine, place = pose[inside], points[inside, 2], cosine[inside], v[inside] * width + u[inside]
    read, claimed = view.depth.ravel()[place], view.mask.ravel()[place]
    off = (read - z) * np.maximum(cosine, 0.35) / (_TOLERANCE + _TOLERANCE_FRACTION * z)
    near = np.maximum(1.0 - off**2, 0.0) * np.where(claimed, 1.0, -0.5)
    gain = np.where(read > 0, near - ((off > 1.0) | ((off < -1.0) & claimed)), 0.0)
    weight, count = cosine / z**2, len(T_camera_object)
    whole = np.maximum(np.bincount(pose, weight, count), 1e-12)
    explained = _explained(T_camera_object, sides.size, view)
    return np.bincount(pose, weight * gain, count) / whole - 0.5 * (1.0 - explained)


def _facing(
    T_camera_object: Transforms, sides: Sides
) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, "n 3"], Float[np.ndarray, " n"]]:
    """Return which pose shows a sample, the sample (camera frame, m), and the cosine of its normal to the ray."""
    R, t = T_camera_object[:, :3, :3], T_camera_object[:, :3, 3]
    eyes = -np.einsum("hij,hi->hj", R, t)
    height = eyes @ sides.normals.T - dot(sides.points, sides.normals)
    x, y, z = (R[:, axis] @ sides.points.T + t[:, axis, None] for axis in range(3))
    distance = np.sqrt(x * x + y * y + z * z)
    seen = np.flatnonzero((height > _GRAZING * distance) & (z > 0.05))
    placed = np.stack([values.ravel()[seen] for values in (x, y, z)], axis=1)
    return seen // height.shape[1], placed, height.ravel()[seen] / distance.ravel()[seen]


def _explained(T_camera_object: Transforms, size: Float[np.ndarray, " 3"], view: DepthView) -> Float[np.ndarray, " h"]:
    """Return the fraction of the mask's points that each pose's box holds, widened by the tolerance."""
    points = view.points[:_EXPLAINED]
    T_object_camera = invert(T_camera_object)
    tolerance = _TOLERANCE + _TOLERANCE_FRACTION * points[:, 2]
    inside = np.ones((len(T_camera_object), len(points)), dtype=bool)
    for axis in range(3):
        along = T_object_camera[:, axis, :3] @ points.T + T_object_camera[:, axis, 3:]
        inside &= np.abs(along) <= size[axis] / 2.0 + tolerance
    return np.asarray(inside.mean(axis=1))


def _moved(T_camera_object: Transforms, T_camera_upright: Float[np.ndarray, "4 4"]) -> Transforms:
    """Return poses moved and turned about gravity, ``_MOVED`` each, always by the same amounts, (h m 4 4)."""
    sampled = np.random.default_rng(0).standard_normal((_MOVED, 4))
    shift = sampled[:, :3] * [_MOVED_BY, _MOVED_BY, _MOVED_BY / 3.0]
    turned = np.stack([make_transform(rotation_z(angle), np.zeros(3)) for angle in _TURNED_BY * sampled[:, 3]])
    T = T_camera_object[:, None] @ turned
    T[..., :3, 3] += shift @ T_camera_upright[:3, :3].T
    return T


def _apart(T_camera_object: Transforms, symmetry: SymmetryGroup) -> Transforms:
    """Return the first ``KEPT`` poses that do not look like an earlier one, within 7 cm and 0.15 rad."""
    left, kept = np.ones(len(T_camera_object), dtype=bool), list[Transform]()
    while left.any() and len(kept) < KEPT:
        first = T_camera_object[np.argmax(left)]
        kept.append(first)
        left &= ~_alike(T_camera_object, first @ symmetry.transforms, left)
    return np.stack(kept)


def _alike(T_camera_object: Transforms, looks: Transforms, requested: Bool[np.ndarray, " h"]) -> Bool[np.ndarray, " h"]:
    found = ~requested
    for look in looks:
        away = np.linalg.norm(T_camera_object[:, :3, 3] - look[:3, 3], axis=1)
        found |= (away <= 0.07) & (rotation_angle(T_camera_object[:, :3, :3], look[None, :3, :3]) <= 0.15)
    return found
