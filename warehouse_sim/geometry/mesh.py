"""Triangle meshes: the one solid that renderers, ray casters and estimators all read.

Even ones: pose errors average over vertices, so vertices must cover a surface evenly. Files of any dialect are read by
trimesh: PLY (text or binary, with polygons, colours, normals), STL, OBJ, GLB.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

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
    # Imported on use: it takes longer to import than all of geometry.
    from scipy.spatial.distance import cdist

    ends = _possible_ends(_unique_rows(points)[0])
    squared = (cdist(ends[start : start + 512], ends, "sqeuclidean") for start in range(0, len(ends), 512))
    return float(np.sqrt(max(float(block.max()) for block in squared)))


def _unique_rows(
    points: Float[np.ndarray, "n 3"],
) -> tuple[Float[np.ndarray, "k 3"], Int[np.ndarray, " n"]]:
    """Return the rows that differ, sorted, and which of them each row is; faster than NumPy's sort of whole rows."""
    order = np.lexsort(points.T[::-1])
    placed = points[order]
    is_first = np.concatenate([[True], (placed[1:] != placed[:-1]).any(axis=1)])
    inverse = np.empty(len(points), dtype=np.int64)
    inverse[order] = np.cumsum(is_first) - 1
    return placed[is_first], inverse


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


def grid_box(size: Float[np.ndarray, " 3"], spacing: float) -> TriangleMesh:
    """Return the surface of a centred box as an even grid; faces share the vertices of their common edges.

    Args:
        size: Edge lengths (m).
        spacing: Largest distance (m) between neighbouring vertices along an edge.
    """
    counts = np.maximum(np.ceil(np.asarray(size) / spacing - 1e-9), 1).astype(int)
    corners = [_side(counts, axis, end) for axis in range(3) for end in (0, 1)]
    lattice, index = _unique_rows(np.concatenate(corners))
    return TriangleMesh((lattice / counts - 0.5) * size, index.reshape(-1, 3).astype(np.int32))


def split_long_edges(mesh: TriangleMesh, longest: float) -> TriangleMesh:
    """Bisect the longest edge of triangles until no edge is longer than ``longest`` (m); equal vertices are merged.

    Neighbours meet edge to edge, since an edge above the limit is halved from both sides (longest-edge bisection,
    Rivara 1984).
    """
    triangles = mesh.vertices[mesh.faces]
    while True:
        edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
        too_long = edges.max(axis=1) > longest
        if not too_long.any():
            break
        first = edges[too_long].argmax(axis=1)[:, None]
        rows = np.arange(len(first))[:, None]
        # Turned so that the edge to halve runs from a to b.
        a, b, c = np.moveaxis(triangles[too_long][rows, (first + np.arange(3)) % 3], 1, 0)
        middle = (a + b) / 2.0
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        triangles = np.concatenate([triangles[~too_long], *halves])
    vertices, index = _unique_rows(triangles.reshape(-1, 3))
    return TriangleMesh(vertices, index.reshape(-1, 3).astype(np.int32))


def _side(counts: np.ndarray, axis: int, end: int) -> np.ndarray:
    """Return the lattice corners (3 a triangle) of one side of a box, counter-clockwise seen from outside."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(counts[u]), np.arange(counts[v]), indexing="ij"))
    around = [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)]
    corners = np.empty((len(i), 6, 3), dtype=int)
    for k, (du, dv) in enumerate(around if end else around[::-1]):
        corners[:, k, axis] = counts[axis] * end
        corners[:, k, u], corners[:, k, v] = i + du, j + dv
    return corners.reshape(-1, 3)


Parts = dict[str, tuple[TriangleMesh, np.ndarray]]


def load_parts(path: Path) -> Parts:
    """Return the named meshes of a file in its own units, each with the 4x4 matrix that places it in the file's scene.

    Raises:
        ValueError: The file cannot be read, with the reason in one line.
    """
    # Imported on use: it takes longer to import than all of geometry.
    import trimesh

    try:
        # From an open file, so that nothing beside it can be reached.
        with path.open("rb") as file:
            loaded = trimesh.load_scene(file, file_type=path.suffix[1:].lower(), process=False)
    except Exception as problem:  # trimesh raises whatever its parsers stumble over
        raise ValueError(" ".join(str(problem).split())[:200]) from problem
    parts: Parts = {}
    for node in sorted(loaded.graph.nodes_geometry):
        T_file_part, name = loaded.graph[node]
        geometry = loaded.geometry[name]
        if hasattr(geometry, "faces"):
            mesh = TriangleMesh(np.asarray(geometry.vertices, float), np.asarray(geometry.faces, np.int32))
            parts[path.stem if len(loaded.geometry) == 1 else node] = mesh, np.asarray(T_file_part)
    return parts


def placed(mesh: TriangleMesh, T_file_part: np.ndarray) -> TriangleMesh:
    """Return the mesh where the file's scene has it; a mirrored one is turned right side out."""
    linear = T_file_part[:3, :3]
    vertices = np.asarray(mesh.vertices, float) @ linear.T + T_file_part[:3, 3]
    mirrored = np.linalg.det(linear) < 0
    return TriangleMesh(vertices, np.ascontiguousarray(mesh.faces[:, ::-1]) if mirrored else mesh.faces)


def load_mesh(path: Path) -> TriangleMesh:
    """Return all triangles of a file as one mesh in its own units.

    Raises:
        ValueError: The file cannot be read, or holds no triangles of finite vertices that exist.
    """
    parts = [placed(*part) for part in load_parts(path).values()]
    mesh = merge(parts) if parts else None
    if mesh is None or not len(mesh.faces):
        raise ValueError("it holds no triangles")
    if not np.isfinite(mesh.vertices).all():
        raise ValueError("it has vertices that are not finite")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise ValueError("it has faces that name vertices which do not exist")
    return mesh


_FACTORS = np.random.default_rng(0).integers(1, 2**63, 64, dtype=np.uint64) * np.uint64(2) + np.uint64(1)


def equal_rows(rows: np.ndarray) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " n"]]:
    """Return one place of each different row, and for each row the number of the one that it equals.

    Numbers follow the hashes, multiplicative ones with a factor a word (Dietzfelbinger et al. 1997, "A reliable
    randomized algorithm for the closest-pair problem"); should two different rows share one, bytes are compared.

    Args:
        rows: (n, ...) contiguous, a row at most 64 words of four bytes.
    """
    if len(rows) == 0:
        return np.zeros(0, int), np.zeros(0, int)
    words = rows.view(np.uint8).reshape(len(rows), -1).view(np.uint32)
    key = np.zeros(len(rows), np.uint64)
    for number in range(words.shape[1]):
        key += words[:, number] * _FACTORS[number]
        key ^= key >> np.uint64(29)
    one, group = _grouped(key)
    if (words[one[group]] != words).any():
        one, group = _grouped(words.view(np.dtype((np.void, words.shape[1] * 4)))[:, 0])
    return one, group


def _grouped(key: np.ndarray) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " n"]]:
    values, group = np.unique(key, return_inverse=True)
    one = np.empty(len(values), int)
    one[group] = np.arange(len(key))
    return one, group.reshape(-1)
