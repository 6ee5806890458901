"""What a depth image says for and against a pose: the surface that should be seen, and the space that should be free.

Samples of the surface that faces the camera, and that no nearer sample covers, are looked up in the image. There the
reading is on the surface, behind it (the camera looks through where the object should be), before it (something covers
it, or where the mask claims the object, something else is there), or missing, which says nothing. Points of the mask
that no sample explains count against the pose, too.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.ranges import Range, ranged

_GRAZING = 0.1
"""Cosine to the ray below which a sample is not believed to be seen."""


@dataclass(frozen=True)
@ranged
class EvidenceConfig:
    """How readings are weighed."""

    samples: Annotated[int, Range(50, 100_000)] = 1500
    """Samples of the whole surface, 50-100,000."""
    tolerance: Annotated[float, Range(0.0001, 1, "m")] = 0.02
    """Within so much (m) of the surface a reading is on it, 0.0001-1, plus ``tolerance_share`` of the distance."""
    tolerance_share: Annotated[float, Range(0, 1)] = 0.004
    """What the tolerance grows by with the distance, 0-1."""
    through: Annotated[float, Range(0, 100)] = 1.0
    """Price of a sample that the camera looks through, against the gain of one that is there, 0-100."""
    before: Annotated[float, Range(0, 100)] = 1.0
    """Price of a sample in the mask with something before it, 0-100."""
    beside: Annotated[float, Range(0, 100)] = 0.5
    """Price of a sample that is there, but that the mask does not claim: a neighbour's surface as a rule, 0-100."""
    unexplained: Annotated[float, Range(0, 100)] = 0.5
    """Price of a share of the mask that nothing explains, 0-100."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Shares of the samples of one pose that face the camera and lie in the image."""

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
    """Share of the points of the mask that lie on the surface."""
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
    """Gravity, a unit vector in the camera frame; None where nobody knows."""


def judge(T_camera_object: Transform, surface: CadSurface, view: DepthView, config: EvidenceConfig) -> Evidence:
    """Return what an image says of a pose.

    Args:
        T_camera_object: The pose.
        surface: Samples of the CAD surface; the first ``config.samples`` share of them are looked up.
        view: The image.
        config: How readings are weighed.
    """
    share = min(config.samples / len(surface.points), 1.0)
    kept = surface.rank < share
    points = transform_points(T_camera_object, surface.points[kept])
    normals = surface.normals[surface.faces[kept]] @ T_camera_object[:3, :3].T
    length = np.linalg.norm(points, axis=1)
    cosine = -(normals * points).sum(axis=1) / np.maximum(length, 1e-9)
    facing = (cosine > _GRAZING) & (points[:, 2] > 0.05)
    points, cosine = points[facing], cosine[facing]
    if len(points) == 0:
        return Evidence(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, -1.0)
    # A sample stands for as many pixels as its patch of surface covers.
    weight = cosine / points[:, 2] ** 2
    u, v = np.rint(view.camera.project(points)).astype(np.int64).T
    open_ = _uncovered(points, u, v, weight)
    points, cosine, weight, u, v = points[open_], cosine[open_], weight[open_], u[open_], v[open_]
    height, width = view.depth.shape
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    beyond = 1.0 - float(weight[inside].sum() / weight.sum())
    if not inside.any():
        return Evidence(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, beyond, 0.0, -1.0)
    z, w = points[inside, 2], weight[inside] / weight[inside].sum()
    read, claimed = view.depth[v[inside], u[inside]].astype(float), view.mask[v[inside], u[inside]]
    tolerance = (config.tolerance + config.tolerance_share * z) / np.maximum(cosine[inside], 0.35)
    off = read - z
    has = read > 0
    near = np.clip(1.0 - (off / tolerance) ** 2, 0.0, 1.0) * has
    behind, nearer = has & (off > tolerance), has & (off < -tolerance)
    supported, beside, through, before, covered, unknown = (
        float((w * values).sum())
        for values in (near * claimed, near * ~claimed, behind, nearer & claimed, nearer & ~claimed, ~has)
    )
    explained = _explained(T_camera_object, surface, kept, view, config)
    price = config.through * through + config.before * before + config.beside * beside
    price += config.unexplained * (1.0 - explained)
    return Evidence(supported, beside, through, before, covered, unknown, beyond, explained, supported - price)


def _uncovered(
    points: Float[np.ndarray, "n 3"],
    u: Int[np.ndarray, " n"],
    v: Int[np.ndarray, " n"],
    weight: Float[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Return which samples no nearer one covers, by a coarse depth buffer of the samples themselves."""
    spread = max(np.ptp(u), np.ptp(v), 1)
    # Cells of about two samples: fine enough for pockets, without gaps that one could look through.
    cell = max(1.0, spread / np.sqrt(max(len(points) / 2.0, 1.0)) * 0.7)
    column, row = ((u - u.min()) / cell).astype(np.int64), ((v - v.min()) / cell).astype(np.int64)
    key = row * (int(column.max()) + 1) + column
    nearest = np.full(int(key.max()) + 1, np.inf)
    np.minimum.at(nearest, key, points[:, 2])
    slack = 0.03 + 0.02 * points[:, 2]
    return points[:, 2] <= nearest[key] + slack


def _explained(
    T_camera_object: Transform,
    surface: CadSurface,
    kept: Bool[np.ndarray, " k"],
    view: DepthView,
    config: EvidenceConfig,
) -> float:
    """Return the share of the mask's points that are inside the object's box, widened by the tolerance."""
    if len(view.points) == 0:
        return 0.0
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    points = transform_points(invert(T_camera_object), view.points)
    tolerance = config.tolerance + config.tolerance_share * view.points[:, 2:]
    return float(((points >= low - tolerance) & (points <= high + tolerance)).all(axis=1).mean())
