"""Clearance of the tines to the surface of the damaged pallet, not to the walls of its nominal pockets.

Boards cross a lane in few places, and those of a damaged pallet stand out or are gone. So the prism that a tine sweeps
is held against every triangle near its lane, and the nearest one counts.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.evaluation.blocks import in_blocks
from warehouse_sim.evaluation.docking.fork import REACH, TINE_THICKNESS, TINE_WIDTH, DockingFace
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, Transforms, invert, transform_points
from warehouse_sim.schema import Pocket

FARTHEST = 0.05
"""Clearances are measured up to this (m); more than any margin requires."""
_AT_ONCE = 40_000
"""Pairs of tine and triangle that are looked at in one go: few enough for the cache of the processor."""


def lane_triangles(mesh: TriangleMesh, face: DockingFace) -> Float[np.ndarray, "m 3 3"]:
    """Return the triangles (m, object frame) that a tine whose middle is in a pocket of ``face`` can come near."""
    triangles = mesh.vertices[mesh.faces]
    near = np.zeros(len(triangles), bool)
    reach = FARTHEST + np.array([TINE_WIDTH, TINE_THICKNESS]) / 2.0
    for pocket in face.pockets:
        local = transform_points(invert(pocket.T_object_pocket), triangles.reshape(-1, 3)).reshape(triangles.shape)
        low, high = local.min(axis=1)[:, 1:], local.max(axis=1)[:, 1:]
        # Half as much again: a tine that is turned reaches out with its corners.
        most = pocket.size[1:] / 2.0 + 1.5 * reach
        near |= ((low <= most) & (high >= -most)).all(axis=1)
    return triangles[near]


def mesh_slack(
    T_object_estimated: Transforms,
    face: DockingFace,
    underside: float,
    triangles: Float[np.ndarray, "m 3 3"],
    T_dock_tines: Sequence[Transform] | None = None,
) -> Float[np.ndarray, " n"]:
    """Return the least clearance (m) around the tines of a fork that trusts an estimate, at most ``FARTHEST``.

    The sweep is that of ``docking_slack``. Negative where a tine meets the surface or what the pallet stands on, -inf
    where the middle of a tine does not stay in its own pocket.

    Args:
        T_object_estimated: "n 4 4" in the true object frame, under the best symmetry.
        face: The approached face with its pockets.
        underside: z of what the pallet stands on (m, object frame).
        triangles: Of the surface near the lanes; see ``lane_triangles``.
        T_dock_tines: Where the tines aim at instead, as in ``docking_slack``.
    """
    aims = [invert(face.T_object_dock) @ pocket.T_object_pocket for pocket in face.pockets]
    clearance = np.full(len(T_object_estimated), FARTHEST)
    for pocket, aim in zip(face.pockets, T_dock_tines or aims, strict=True):
        T_object_tine = T_object_estimated @ face.T_object_dock @ aim
        floor = _lowest_under(invert(face.T_object_dock) @ T_object_tine, face) - underside
        here = np.minimum(floor, clearance_to_triangles(T_object_tine, triangles))
        clearance = np.minimum(clearance, np.where(_in_lane(T_object_tine, pocket), here, -np.inf))
    return clearance


def clearance_to_triangles(T_object_tine: Transforms, triangles: Float[np.ndarray, "m 3 3"]) -> Float[np.ndarray, " n"]:
    """Return how much (m) a swept tine can grow to all four sides before it meets a triangle, at most ``FARTHEST``."""
    half = np.array([TINE_WIDTH, TINE_THICKNESS]) / 2.0
    clearance = np.full(len(T_object_tine), FARTHEST)
    corners = np.concatenate([triangles.reshape(-1, 3).T, np.ones((1, 3 * len(triangles)))])

    def work(block: slice) -> None:
        T = invert(T_object_tine[block])
        x, y, z = ((T[:, axis] @ corners).reshape(len(T), -1, 3) for axis in range(3))
        (back, _), sideways, upwards = _extent(x), _extent(y), _extent(z)
        gap = np.maximum(_beyond(*sideways) - half[0], _beyond(*upwards) - half[1])
        # A corner that the tine passes is as near as any point of its triangle has to be.
        at_corners = np.maximum(np.abs(y) - half[0], np.abs(z) - half[1])
        least = np.minimum(FARTHEST, np.where(x <= REACH, at_corners, np.inf).min(axis=(1, 2)))
        row, which = np.nonzero((back < REACH) & (gap < least[:, None]))
        np.minimum.at(least, row, _clearance(np.stack([axis[row, which] for axis in (x, y, z)], axis=-1), half, REACH))
        clearance[block] = least

    if len(triangles):
        in_blocks(len(T_object_tine), _AT_ONCE // len(triangles), work)
    return clearance


def _extent(of_corners: Float[np.ndarray, "n m 3"]) -> tuple[Float[np.ndarray, "n m"], Float[np.ndarray, "n m"]]:
    """Return the least and the largest coordinate of each triangle."""
    one, two, three = (of_corners[..., corner] for corner in range(3))
    return np.minimum(np.minimum(one, two), three), np.maximum(np.maximum(one, two), three)


def _beyond(low: Float[np.ndarray, "n m"], high: Float[np.ndarray, "n m"]) -> Float[np.ndarray, "n m"]:
    """Return how far an interval begins from zero, to either side; negative around it."""
    return np.maximum(low, -high)


def _lowest_under(T_dock_tine: Transforms, face: DockingFace) -> Float[np.ndarray, " n"]:
    """Return the least z (m, object frame) of a swept tine under the object; beyond it there may be no ground.

    Docking frames are upright in the object's: only their origins' heights differ.
    """
    y, z = np.array([TINE_WIDTH, TINE_THICKNESS]) / 2.0
    tip = transform_points(T_dock_tine, np.array([[REACH, side, over] for side in (-y, y) for over in (-z, z)]))
    ahead = T_dock_tine[:, None, :3, 0]
    slope = np.where(np.abs(ahead[..., 0]) < 1e-9, 1e-9, ahead[..., 0])
    entry, end = (tip[..., 2] + (x - tip[..., 0]) / slope * ahead[..., 2] for x in (0.0, face.depth))
    end = np.where(tip[..., 0] < face.depth, tip[..., 2], end)
    lowest = np.where(tip[..., 0] > 0.0, np.minimum(entry, end), np.inf).min(axis=1)
    return lowest + float(face.T_object_dock[2, 3])


def _in_lane(T_object_tine: Transforms, pocket: Pocket) -> np.ndarray:
    """Return whether the middle of each tine is in the section of its pocket from the entry to where it ends."""
    T = invert(pocket.T_object_pocket) @ T_object_tine
    ahead, start = T[:, :3, 0], T[:, :3, 3]
    slope = np.where(np.abs(ahead[:, 0]) < 1e-9, 1e-9, ahead[:, 0])
    tip = start[:, 0] + REACH * ahead[:, 0]
    inside = tip > 0.0
    for end in (np.zeros(len(T)), np.minimum(tip, pocket.size[0])):
        at = start + ((end - start[:, 0]) / slope)[:, None] * ahead
        inside &= (np.abs(at[:, 1:]) < pocket.size[1:] / 2.0).all(axis=1)
    return inside


def _clearance(
    corners: Float[np.ndarray, "k 3 3"], half: Float[np.ndarray, " 2"], reach: float
) -> Float[np.ndarray, " k"]:
    """Return the least of max(|y| - half, |z| - half) over each triangle (tine frame) where x <= ``reach``.

    That is convex over a convex polygon: it is least inside, which only a polygon around the axis holds, or on an edge;
    along an edge it is made of straight pieces, and least at one of their ends.
    """
    start = corners
    along = np.roll(corners, -1, axis=1) - corners
    first, last = np.zeros(start.shape[:2]), np.ones(start.shape[:2])
    slope = np.where(np.abs(along[..., 0]) < 1e-12, 1e-12, along[..., 0])
    cut = (reach - start[..., 0]) / slope
    first = np.where(slope < 0.0, np.maximum(cut, 0.0), first)
    last = np.where(slope > 0.0, np.minimum(cut, 1.0), last)
    kept = first <= last
    least = np.where(kept, _least_along(start, along, first, last, half), np.inf).min(axis=1)
    # Where the plane of the tip cuts the triangle, the cut is an edge, too.
    crossed = (cut > 0.0) & (cut < 1.0)
    points = start + np.clip(cut, 0.0, 1.0)[..., None] * along
    two = np.argsort(~crossed, axis=1, kind="stable")[:, :2]
    one, other = (np.take_along_axis(points, two[:, [i], None], axis=1)[:, 0] for i in (0, 1))
    on_cut = _least_along(one, other - one, np.zeros(len(one)), np.ones(len(one)), half)
    least = np.where(crossed.sum(axis=1) >= 2, np.minimum(least, on_cut), least)
    return np.where(_around_axis(corners, reach), -half.min(), least)


def _least_along(
    start: np.ndarray, along: np.ndarray, first: np.ndarray, last: np.ndarray, half: np.ndarray
) -> np.ndarray:
    """Return the least of max(|y| - half, |z| - half) along ``start + t along`` for t from ``first`` to ``last``."""
    y, z, dy, dz = start[..., 1], start[..., 2], along[..., 1], along[..., 2]
    lines = [(y, dy, 0.0), (z, dz, 0.0)]
    lines += [(y - side * z, dy - side * dz, sign * (half[0] - half[1])) for side in (1, -1) for sign in (1, -1)]
    times = [first, last]
    for value, rate, level in lines:
        times.append(np.clip((level - value) / np.where(np.abs(rate) < 1e-12, 1e-12, rate), first, last))
    t = np.stack(times)
    return np.maximum(np.abs(y + t * dy) - half[0], np.abs(z + t * dz) - half[1]).min(axis=0)


def _around_axis(corners: Float[np.ndarray, "k 3 3"], reach: float) -> np.ndarray:
    """Return whether the axis of the tine goes through each triangle before the tip."""
    y, z = corners[..., 1], corners[..., 2]
    # Twice the areas of the triangles that the axis spans with each edge.
    areas = y * np.roll(z, -1, axis=1) - np.roll(y, -1, axis=1) * z
    total = areas.sum(axis=1)
    weights = np.roll(areas, -1, axis=1) / np.where(np.abs(total) < 1e-15, 1.0, total)[:, None]
    at = (weights * corners[..., 0]).sum(axis=1)
    return (np.abs(total) > 1e-15) & (weights >= 0.0).all(axis=1) & (at <= reach)
