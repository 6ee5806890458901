"""Triangle meshes: the one solid that renderers, ray casters and estimators all read."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.geometry.boxes import box_corners


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangle soup with outward counter-clockwise faces; compared by identity so that equal parts are instanced."""

    vertices: Float[np.ndarray, "n 3"]
    """Positions (m)."""
    faces: Int[np.ndarray, "m 3"]
    """Vertex indices of each triangle, counter-clockwise seen from outside."""

    def face_normals(self) -> Float[np.ndarray, "m 3"]:
        """Return unit outward normals; a degenerate face has a zero normal."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        normals = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return normals / np.where(length > 0, length, 1.0)

    def face_areas(self) -> Float[np.ndarray, " m"]:
        """Return the area of each face (m^2)."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


@cache
def unit_box() -> TriangleMesh:
    """Return the shared centred cube of edge 1 m; parts scale it."""
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return TriangleMesh(box_corners(np.ones(3)), np.array(faces, dtype=np.int32))


def merge(meshes: list[TriangleMesh]) -> TriangleMesh:
    """Return one mesh that holds all triangles of ``meshes``."""
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    faces = [mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]
    return TriangleMesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces).astype(np.int32))


def sample_surface(
    mesh: TriangleMesh, count: int, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "k 3"], Float[np.ndarray, "k 3"]]:
    """Draw ``count`` points uniformly by area; return points (m) and the unit normals of their faces.

    Uniform in each triangle by the square-root map (Osada et al. 2002, section 4.2).
    """
    areas = mesh.face_areas()
    index = rng.choice(len(areas), size=count, p=areas / areas.sum())
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[index]], 1, 0)
    r1, r2 = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    return (1 - r1) * a + r1 * (1 - r2) * b + r1 * r2 * c, mesh.face_normals()[index]


_FEW, _CELLS = 512, 24
"""Points of which every pair is looked at, and cells along the diameter where there are more."""


def diameter(points: Float[np.ndarray, "n 3"]) -> float:
    """Return the largest distance (m) between any two of ``points``, in blocks to bound memory."""
    unique = _possible_ends(np.unique(points, axis=0))
    largest = 0.0
    for start in range(0, len(unique), 512):
        block = unique[start : start + 512]
        squared = ((block[:, None] - unique[None]) ** 2).sum(axis=-1)
        largest = max(largest, float(squared.max()))
    return float(np.sqrt(largest))


def _possible_ends(points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "k 3"]:
    """Return the points that may be an end of the diameter: others have nothing so far from them in their box."""
    low, high = points.min(axis=0), points.max(axis=0)
    along = points @ np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], dtype=float).T
    known = np.linalg.norm(points[along.argmax(axis=0)] - points[along.argmin(axis=0)], axis=1).max()
    reach = np.linalg.norm(np.maximum(points - low, high - points), axis=1)
    # A millionth of room for rounding, so that the ends themselves stay.
    points = points[reach >= known * (1.0 - 1e-6)]
    return points if len(points) < _FEW else _ends_by_cell(points, known)


def _ends_by_cell(points: Float[np.ndarray, "n 3"], known: float) -> Float[np.ndarray, "k 3"]:
    """Return the points in cells that may hold an end of the diameter, which is ``known`` or more."""
    for start in (points[0], points[-1]):
        end = start
        for _ in range(4):
            farther = points[np.linalg.norm(points - end, axis=1).argmax()]
            known, end = max(known, float(np.linalg.norm(farther - end))), farther
    cell = ((points - points.min(axis=0)) / (known / _CELLS)).astype(np.int64)
    _, of_point = np.unique(cell @ np.array([1 << 20, 1 << 10, 1]), return_inverse=True)
    low, high = np.full((2, int(of_point.max()) + 1, 3), np.inf)
    np.minimum.at(low, of_point, points)
    np.minimum.at(high, of_point, -points)
    # The farthest corners of two cells' boxes: nothing in them is farther apart.
    most = np.linalg.norm(np.maximum(-high[:, None] - low[None], -high[None] - low[:, None]), axis=2).max(axis=1)
    return points[(most >= known * (1.0 - 1e-6))[of_point]]
