"""Meshes as the rasteriser reads them: flat faces, and at each corner how far it lies from the edges of its face."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Int32, UInt8

from warehouse_sim.geometry.facets import Facets, facets, parallelograms
from warehouse_sim.geometry.mesh import TriangleMesh

CORNER = np.dtype([("position", "f4", 3), ("normal", "f4", 3), ("to_edge", "u1", 4)])
"""A vertex on the graphics device."""
CORNER_FORMAT = "3f4 3f4 4f1"
_NO_EDGE = 255


@dataclass(frozen=True, eq=False)
class FlatMesh:
    """Corners that are split where neighbouring faces differ, and the triangles between them."""

    corners: np.ndarray
    """(k,) of dtype ``CORNER``; ``to_edge`` holds four functions that are linear on a face, 0 on one of its edges and
    255 at the far side, or 255 everywhere where there is no such edge. What two coplanar triangles share is no edge."""
    triangles: Int32[np.ndarray, "m 3"]


def flat_mesh(mesh: TriangleMesh, known: Facets | None = None) -> FlatMesh:
    """Prepare ``mesh``; halves of a parallelogram become one face with four edges, which needs no more corners.

    Args:
        mesh: What is rendered.
        known: Its facets, where they are known.
    """
    found = facets(mesh) if known is None else known
    pair, turn = parallelograms(found)
    single = np.setdiff1d(np.arange(len(found.faces)), pair)
    quads = _quad_corners(mesh, found, pair, turn)
    barycentric = _barycentric(found.inner[single])
    lone = _corners(mesh.vertices[found.faces[single]], found.normals[single], barycentric)
    corners = np.concatenate([quads.ravel(), lone.ravel()])
    index = np.arange(4 * len(pair)).reshape(-1, 4)[:, [0, 1, 3, 1, 2, 3]].reshape(-1, 3)
    triangles = np.concatenate([index, 4 * len(pair) + np.arange(3 * len(single)).reshape(-1, 3)])
    unique, inverse = np.unique(corners.view(np.dtype((np.void, CORNER.itemsize))), return_inverse=True)
    return FlatMesh(unique.view(CORNER), inverse[triangles].astype(np.int32))


def _quad_corners(
    mesh: TriangleMesh, found: Facets, pair: Int[np.ndarray, "q 2"], turn: Int[np.ndarray, "q 2"]
) -> np.ndarray:
    """Return the corners (q, 4) of parallelograms, counter-clockwise from the first triangle's corner off the diagonal.

    Edges 0 to 3 follow that corner in this order; across a parallelogram opposite edges add up to one.
    """
    (first, second), (i, j) = pair.T, turn.T
    faces, inner = found.faces, found.inner
    ring = [faces[first, i], faces[first, (i + 1) % 3], faces[second, j], faces[first, (i + 2) % 3]]
    hidden = [
        inner[first, (i + 2) % 3],
        inner[second, (j + 1) % 3],
        inner[second, (j + 2) % 3],
        inner[first, (i + 1) % 3],
    ]
    values = np.array([[0, 0, 1, 1], [1, 0, 0, 1], [1, 1, 0, 0], [0, 1, 1, 0]], np.uint8).T * _NO_EDGE
    to_edge = np.where(np.stack(hidden, axis=1)[:, None], _NO_EDGE, values[None]).astype(np.uint8)
    return _corners(mesh.vertices[np.stack(ring, axis=1)], found.normals[first], to_edge)


def _barycentric(inner: Bool[np.ndarray, "m 3"]) -> UInt8[np.ndarray, "m 3 4"]:
    values = np.concatenate([np.eye(3, dtype=np.uint8) * _NO_EDGE, np.full((3, 1), _NO_EDGE, np.uint8)], axis=1)
    hidden = np.concatenate([inner, np.ones((len(inner), 1), bool)], axis=1)
    return np.where(hidden[:, None], _NO_EDGE, values[None]).astype(np.uint8)


def _corners(
    points: Float[np.ndarray, "n c 3"], normals: Float[np.ndarray, "n 3"], to_edge: UInt8[np.ndarray, "n c 4"]
) -> np.ndarray:
    corners = np.zeros(points.shape[:2], CORNER)
    corners["position"], corners["normal"], corners["to_edge"] = points, normals[:, None], to_edge
    return corners
