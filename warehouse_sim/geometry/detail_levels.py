"""Coarser meshes for what is seen from afar: thin sheets lose their rims."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.facets import Facets, facets, parallelograms, plane_regions
from warehouse_sim.geometry.mesh import TriangleMesh

_FEWER = 0.8
"""A level must have at most this fraction of the triangles of the level before."""
_FIRST = 0.25e-3
"""Error up to which the first coarser level may go (m); each next one may go twice as far."""
_MOST = 6


@dataclass(frozen=True, eq=False)
class DetailLevel:
    """A mesh that may stand for another one."""

    mesh: TriangleMesh
    error: float
    """Largest distance (m) from a point of either surface to the other surface."""


def detail_levels(mesh: TriangleMesh, known: Facets | None = None) -> tuple[DetailLevel, ...]:
    """Return ``mesh`` itself and coarser ones, the finest first.

    Print on a carton, the slots of an upright and the ribs of a tote are sheets: two large sides and, around them, a
    rim of narrow faces. A rim face whose two long edges belong to faces that stay is within half its width of them, so
    it can go where that is less than the eye can tell. Nothing moves, hence print stays before what it is printed on.

    Args:
        mesh: The finest level.
        known: Its facets, where they are known.
    """
    levels = [DetailLevel(mesh, 0.0)]
    found = facets(mesh) if known is None else known
    pair, turn = parallelograms(found)
    rim, error = _rims(found, pair, turn, plane_regions(found))
    pair = pair[rim]
    for step in range(_MOST):
        gone = error <= _FIRST * 2.0**step
        left = len(found.faces) - 2 * np.count_nonzero(gone)
        if gone.any() and 0 < left <= _FEWER * len(levels[-1].mesh.faces):
            kept = np.ones(len(found.faces), bool)
            kept[pair[gone].ravel()] = False
            levels.append(DetailLevel(TriangleMesh(mesh.vertices, found.faces[kept]), float(error[gone].max())))
    return tuple(levels)


def _rims(
    found: Facets, pair: Int[np.ndarray, "q 2"], turn: Int[np.ndarray, "q 2"], region: Int[np.ndarray, " m"]
) -> tuple[Bool[np.ndarray, " q"], Float[np.ndarray, " r"]]:
    """Return which of the ``parallelograms`` are rim faces, and half the width of each of these (m)."""
    points = found.points
    row, (i, j) = np.arange(len(pair)), turn.T
    corner = points[pair[:, 0], i]
    sides = np.stack([points[pair[:, 0], (i + k) % 3] - corner for k in (1, 2)], axis=1)
    lengths = np.linalg.norm(sides, axis=2)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    width = area / lengths.max(axis=1)
    # A side that runs from the corner to the next but k is opposite the corner k before it.
    long = lengths.argmax(axis=1)
    beyond = [
        found.across[pair[:, 0], np.where(long == 0, (i + 2) % 3, (i + 1) % 3)],
        found.across[pair[:, 1], np.where(long == 0, (j + 2) % 3, (j + 1) % 3)],
    ]
    region_width = _region_widths(found, region)
    alone = np.bincount(region)[region[pair[:, 0]]] == 2
    wider = alone.copy()
    for edge in beyond:
        wider &= (edge >= 0) & (region_width[region[edge // 3]] > 1.2 * width)
    leaned_on = _touched(region, beyond, row[wider])
    rim = wider & ~leaned_on[region[pair[:, 0]]]
    return rim, width[rim] / 2


def _region_widths(found: Facets, region: Int[np.ndarray, " m"]) -> Float[np.ndarray, " k"]:
    """Return about how wide each flat region is across its longest direction (m)."""
    points = found.points
    doubled = np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1)
    count = region.max(initial=-1) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for corner in range(3):
        np.minimum.at(low, region, points[:, corner])
        np.maximum.at(high, region, points[:, corner])
    return np.bincount(region, doubled / 2, count) / np.linalg.norm(high - low, axis=1)


def _touched(
    region: Int[np.ndarray, " m"], beyond: list[Int[np.ndarray, " q"]], rows: Int[np.ndarray, " k"]
) -> Bool[np.ndarray, " r"]:
    """Return which regions hold the long edges of the faces in ``rows``: they must stay."""
    touched = np.zeros(region.max(initial=-1) + 1, bool)
    for edge in beyond:
        touched[region[edge[rows] // 3]] = True
    return touched
