"""Coarser meshes for what is seen from afar, by flat facets: thin sheets lose their rims."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from warehouse_sim.geometry.mesh import TriangleMesh, equal_rows


@dataclass(frozen=True, eq=False)
class Facets:
    """The triangles of a mesh that have an area, and their neighbours; edge k is opposite corner k."""

    faces: Int[np.ndarray, "m 3"]
    points: Float[np.ndarray, "m 3 3"]
    """Positions of their corners (m)."""
    normals: Float[np.ndarray, "m 3"]
    """Unit outward normals, rounded so that those of coplanar triangles are equal."""
    across: Int[np.ndarray, "m 3"]
    """Number ``3 * triangle + edge`` on the other side of each edge; -1 where there are none or several."""
    inner: Bool[np.ndarray, "m 3"]
    """Whether the edge lies between triangles of one plane, so that nobody can see it."""
    partner: Int[np.ndarray, "m 3"]
    """As ``across``, for inner edges that just two triangles of the plane share."""

    @cached_property
    def halves(self) -> tuple[Int[np.ndarray, "q 2"], Int[np.ndarray, "q 2"]]:
        """Its ``parallelograms``."""
        return parallelograms(self)


def facets(mesh: TriangleMesh) -> Facets:
    """Find the neighbours of each triangle; vertices at the same place count as one."""
    normals = np.round(mesh.face_normals(), 6) + 0.0  # no negative zeros: they would tell equal normals apart
    solid = normals.any(axis=1)
    normals, faces = normals[solid], mesh.faces[solid]
    welded = _numbered(mesh.vertices + 0.0)
    corners = welded[faces]
    ends = np.stack([corners[:, [1, 2]], corners[:, [2, 0]], corners[:, [0, 1]]], axis=1).reshape(-1, 2)
    edge = ends.min(axis=1) * (len(welded) + 1) + ends.max(axis=1)
    plane = _numbered(normals)
    _, edge = np.unique(edge, return_inverse=True)
    in_plane = edge * (plane.max(initial=0) + 1) + np.repeat(plane, 3)
    across, _ = _paired_variants(edge)
    partner, shared = _paired_variants(np.unique(in_plane, return_inverse=True)[1])
    shape = faces.shape
    points = mesh.vertices[faces]
    return Facets(faces, points, normals, across.reshape(shape), shared.reshape(shape), partner.reshape(shape))


def parallelograms(found: Facets) -> tuple[Int[np.ndarray, "q 2"], Int[np.ndarray, "q 2"]]:
    """Return the pairs of coplanar triangles that halve a parallelogram along the longest edge of both.

    Returns:
        The two triangles of each pair, and for each of them which of its edges that is.
    """
    points = found.points
    edges = points[:, [2, 0, 1]] - points[:, [1, 2, 0]]
    longest = np.round(np.linalg.norm(edges, axis=2), 9).argmax(axis=1)
    rows = np.arange(len(points))
    paired_variant = found.partner[rows, longest]
    other = np.where(paired_variant >= 0, paired_variant // 3, rows)
    mutual = (paired_variant >= 0) & (longest[other] == paired_variant % 3) & (rows < other)
    pair = np.column_stack([rows[mutual], other[mutual]])
    turn = longest[pair]
    a, b, row = points[pair[:, 0]], points[pair[:, 1]], np.arange(len(pair))
    i = turn[:, 0]
    fourth = a[row, (i + 1) % 3] + a[row, (i + 2) % 3] - a[row, i]
    fits = (np.abs(fourth - b[row, turn[:, 1]]) < 1e-6).all(axis=1)
    return pair[fits], turn[fits]


def plane_regions(found: Facets) -> Int[np.ndarray, " m"]:
    """Return for each triangle the number of the connected flat region that it belongs to."""
    count, (here, edge) = len(found.faces), np.nonzero(found.partner >= 0)
    there = found.partner[here, edge] // 3
    starts = np.append(0, np.cumsum(np.bincount(here, minlength=count)))
    neighbours = csr_array((np.ones(len(here)), there, starts), shape=(count, count))
    return connected_components(neighbours, directed=False)[1]


def _numbered(rows: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, " n"]:
    """Return a number for each row, equal for rows of equal bytes."""
    return equal_rows(np.ascontiguousarray(rows))[1]


def _paired_variants(group: Int[np.ndarray, " n"]) -> tuple[Int[np.ndarray, " n"], Bool[np.ndarray, " n"]]:
    """Return for each number the place of the only other equal one, or -1, and whether it occurs more than once.

    Args:
        group: Numbers that count from 0.
    """
    count = np.bincount(group)[group]
    paired_variant = np.full(len(group), -1)
    two = np.flatnonzero(count == 2)
    pairs = two[np.argsort(group[two], kind="stable")].reshape(-1, 2)
    paired_variant[pairs[:, 0]], paired_variant[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    return paired_variant, count > 1


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
    pair, turn = found.halves
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
    order = np.argsort(region, kind="stable")
    first = np.searchsorted(region[order], np.arange(count))
    low = np.minimum.reduceat(points.min(axis=1)[order], first) if count else np.zeros((0, 3))
    high = np.maximum.reduceat(points.max(axis=1)[order], first) if count else np.zeros((0, 3))
    return np.bincount(region, doubled / 2, count) / np.linalg.norm(high - low, axis=1)


def _touched(
    region: Int[np.ndarray, " m"], beyond: list[Int[np.ndarray, " q"]], rows: Int[np.ndarray, " k"]
) -> Bool[np.ndarray, " r"]:
    """Return which regions hold the long edges of the faces in ``rows``: they must stay."""
    touched = np.zeros(region.max(initial=-1) + 1, bool)
    for edge in beyond:
        touched[region[edge[rows] // 3]] = True
    return touched
