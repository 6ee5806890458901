"""What a depth image says for and against a pose: the surface that should be seen, and the space that should be free.

Samples of the surface that faces the camera, and that no nearer sample covers, are looked up in the image. There the
reading is on the surface, behind it (the camera looks through where the object should be), before it (something covers
it, or where the mask claims the object, something else is there), or missing, which says nothing. Points of the mask
that no sample explains count against the pose, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.estimators.pose.icp.surface import CadSurface, dot
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, Transforms, invert, transform_points

_GRAZING = 0.1
"""Cosine to the ray below which a sample is not believed to be seen."""
_POINTS = 400
"""Points of the mask that are requested an explanation, the first ones."""


TOLERANCE_FRACTION = 0.004
"""What the tolerance of readings grows by with the distance."""
_BEFORE = 1.0
"""Price of a sample in the mask with something before it."""
_BESIDE = 0.5
"""Price of a sample that is there, but that the mask does not claim: a neighbour's surface as a rule."""
_UNEXPLAINED = 0.5
"""Price of a fraction of the mask that nothing explains."""


class VerificationConfig(NamedTuple):
    """How finely a pose is looked at, and how readings are weighed."""

    samples: int
    """Samples of the whole surface."""
    tolerance: float = 0.02
    """Within so much (m) of the surface a reading is on it, plus ``TOLERANCE_FRACTION`` of the distance."""
    through: float = 1.0
    """Price of a sample that the camera looks through, against the gain of one that is there."""


@dataclass(frozen=True, eq=False)
class Verification:
    """Fractions of the samples of one pose that face the camera and lie in the image."""

    supported: float
    """In the mask and on the surface, weighted by how well."""
    beside: float
    """On the surface as well, but beside the mask."""
    through: float
    """The camera reads what lies behind."""
    before: float
    """In the mask, but something is nearer."""
    covered: float
    """Beside the mask, and something is nearer: nothing against the pose."""
    unknown: float
    """No reading."""
    beyond: float
    """Of all samples that face the camera: outside the image."""
    explained: float
    """Fraction of the points of the mask that lie on the surface."""
    score: float
    """Gains less prices; at most 1."""


@dataclass(frozen=True, eq=False)
class DepthView:
    """A depth image with the pixels that a mask claims for one object."""

    camera: PinholeCamera
    depth: Float32[np.ndarray, "h w"]
    mask: Bool[np.ndarray, "h w"]
    points: Float[np.ndarray, "p 3"]
    """Some of the mask's points (camera frame, m), in random order."""
    down: Float[np.ndarray, " 3"] | None = None
    """Gravity, a unit vector in the camera frame; None if unknown."""


def judge(T_camera_object: Transform, surface: CadSurface, view: DepthView, config: VerificationConfig) -> Verification:
    """Return what an image says of a pose.

    Args:
        T_camera_object: The pose.
        surface: Samples of the CAD surface; the first ``config.samples`` fraction of them are looked up.
        view: The image.
        config: How readings are weighed.
    """
    return judge_all(T_camera_object[None], surface, view, config)[0]


def judge_all(
    T_camera_object: Transforms, surface: CadSurface, view: DepthView, config: VerificationConfig
) -> list[Verification]:
    """Return what an image says of each of some poses (h 4 4) of one object."""
    seen = _samples_in_sight(T_camera_object, surface, view.camera, config.samples)
    height, width = view.depth.shape
    inside = (seen.u >= 0) & (seen.u < width) & (seen.v >= 0) & (seen.v < height)
    count = len(T_camera_object)
    whole = np.bincount(seen.pose, seen.weight, count)
    within = np.bincount(seen.pose[inside], seen.weight[inside], count)
    pose, z, cosine = seen.pose[inside], seen.z[inside], seen.cosine[inside]
    place = seen.v[inside] * width + seen.u[inside]
    read, claimed = view.depth.ravel()[place].astype(float), view.mask.ravel()[place]
    tolerance = (config.tolerance + TOLERANCE_FRACTION * z) / np.maximum(cosine, 0.35)
    off = read - z
    has = read > 0
    near = np.clip(1.0 - (off / tolerance) ** 2, 0.0, 1.0) * has
    behind, nearer = has & (off > tolerance), has & (off < -tolerance)
    w = seen.weight[inside] / within[pose]
    fractions = np.stack(
        [
            np.bincount(pose, w * values, count)
            for values in (near * claimed, near * ~claimed, behind, nearer & claimed, nearer & ~claimed, ~has)
        ],
        axis=1,
    )
    explained = _explained(T_camera_object, surface, view, config)
    beyond = 1.0 - within / np.where(whole > 0.0, whole, 1.0)
    return [
        _weighed([float(value) for value in row], float(out), float(fraction), config) if some > 0.0 else _UNSEEN
        for row, out, fraction, some in zip(fractions, beyond, explained, within, strict=True)
    ]


_UNSEEN = Verification(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, -1.0)
"""Of a pose that shows no side within the image."""


def _weighed(fractions: Sequence[float], beyond: float, explained: float, config: VerificationConfig) -> Verification:
    """Return the verification with its score; shares are in the order of its fields."""
    supported, beside, through, before, covered, unknown = fractions
    price = config.through * through + _BEFORE * before + _BESIDE * beside
    price += _UNEXPLAINED * (1.0 - explained)
    return Verification(supported, beside, through, before, covered, unknown, beyond, explained, supported - price)


class _InSight(NamedTuple):
    """Samples of several poses that face the camera and that no nearer sample of the pose covers."""

    pose: Int[np.ndarray, " n"]
    """Number of the pose of each, in rising order."""
    z: Float[np.ndarray, " n"]
    cosine: Float[np.ndarray, " n"]
    """Of the angle between normal and ray."""
    weight: Float[np.ndarray, " n"]
    """A sample stands for as many pixels as its patch of surface covers."""
    u: Int[np.ndarray, " n"]
    v: Int[np.ndarray, " n"]


def _samples_in_sight(
    T_camera_object: Transforms, surface: CadSurface, camera: PinholeCamera, samples: int
) -> _InSight:
    points, normals = surface.thinned(samples)
    R = T_camera_object[:, :3, :3]
    placed = points @ np.swapaxes(R, 1, 2) + T_camera_object[:, None, :3, 3]
    turned = normals @ np.swapaxes(R, 1, 2)
    cosine = -dot(turned, placed) / np.maximum(np.sqrt(dot(placed, placed)), 1e-9)
    facing = (cosine > _GRAZING) & (placed[..., 2] > 0.05)
    pose, number = np.nonzero(facing)
    placed, cosine = placed[pose, number], cosine[pose, number]
    u, v = np.rint(camera.project(placed)).astype(np.int64).T
    found = _InSight(pose, placed[:, 2], cosine, cosine / placed[:, 2] ** 2, u, v)
    if len(pose) == 0:
        return found
    open_ = _uncovered(found)
    return _InSight(*(values[open_] for values in found))


def _uncovered(seen: _InSight) -> Bool[np.ndarray, " n"]:
    """Return which samples no nearer one of their pose covers, by a coarse depth buffer of the samples themselves."""
    first = np.flatnonzero(np.diff(seen.pose, prepend=-1))
    counts = np.diff(np.append(first, len(seen.pose)))
    low = [np.minimum.reduceat(values, first) for values in (seen.u, seen.v)]
    high = [np.maximum.reduceat(values, first) for values in (seen.u, seen.v)]
    spread = np.maximum(np.maximum(high[0] - low[0], high[1] - low[1]), 1)
    # Cells of about two samples: fine enough for pockets, without gaps that one could look through.
    cell = np.maximum(1.0, spread / np.sqrt(np.maximum(counts / 2.0, 1.0)) * 0.7)
    number = np.repeat(np.arange(len(first)), counts)
    column, row = (
        ((values - least[number]) / cell[number]).astype(np.int64)
        for values, least in zip((seen.u, seen.v), low, strict=True)
    )
    columns, rows = int(column.max()) + 1, int(row.max()) + 1
    key = (number * rows + row) * columns + column
    nearest = np.full(len(first) * rows * columns, np.inf)
    np.minimum.at(nearest, key, seen.z)
    slack = 0.03 + 0.02 * seen.z
    return seen.z <= nearest[key] + slack


def _explained(
    T_camera_object: Transforms, surface: CadSurface, view: DepthView, config: VerificationConfig
) -> Float[np.ndarray, " h"]:
    """Return the fraction of the mask's points that are inside each pose's box, widened by the tolerance."""
    if len(view.points) == 0:
        return np.zeros(len(T_camera_object))
    seen = view.points[:_POINTS]
    points = transform_points(invert(T_camera_object), np.broadcast_to(seen, (len(T_camera_object), *seen.shape)))
    tolerance = config.tolerance + TOLERANCE_FRACTION * seen[:, 2:]
    return ((points >= surface.low - tolerance) & (points <= surface.high + tolerance)).all(axis=2).mean(axis=1)
