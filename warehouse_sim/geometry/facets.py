"""How the triangles of a mesh meet: across which edges, in one plane or at an angle, as halves of a parallelogram."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warehouse_sim.geometry.mesh import TriangleMesh


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
    partner, shared = _paired_variants(in_plane)
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
    neighbours = coo_array((np.ones(len(here), bool), (here, there)), shape=(count, count))
    return connected_components(neighbours, directed=False)[1]


def _numbered(rows: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, " n"]:
    """Return a number for each row, equal for rows of equal bytes; several times as fast as ``np.unique(axis=0)``."""
    whole = np.ascontiguousarray(rows).view(np.dtype((np.void, rows.itemsize * 3)))
    return np.unique(whole, return_inverse=True)[1].reshape(-1)


def _paired_variants(key: Int[np.ndarray, " n"]) -> tuple[Int[np.ndarray, " n"], Bool[np.ndarray, " n"]]:
    """Return for each key the place of the only other equal one, or -1, and whether it occurs more than once."""
    _, group, count = np.unique(key, return_inverse=True, return_counts=True)
    paired_variant = np.full(len(key), -1)
    two = np.flatnonzero(count[group] == 2)
    pairs = two[np.argsort(group[two], kind="stable")].reshape(-1, 2)
    paired_variant[pairs[:, 0]], paired_variant[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    return paired_variant, count[group] > 1
