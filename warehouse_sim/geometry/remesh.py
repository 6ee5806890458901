"""Even meshes: pose errors average over vertices, so vertices must cover a surface evenly."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import TriangleMesh


def grid_box(size: Float[np.ndarray, " 3"], spacing: float) -> TriangleMesh:
    """Return the surface of a centred box as an even grid; faces share the vertices of their common edges.

    Args:
        size: Edge lengths (m).
        spacing: Largest distance (m) between neighbouring vertices along an edge.
    """
    counts = np.maximum(np.ceil(np.asarray(size) / spacing - 1e-9), 1).astype(int)
    corners = [_side(counts, axis, end) for axis in range(3) for end in (0, 1)]
    lattice, index = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
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
    vertices, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
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
