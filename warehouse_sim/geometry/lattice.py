"""Solids of filled cells on a grid of unequal spacing: what is moulded or cut at right angles becomes one mesh."""

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.mesh import TriangleMesh


def lattice_solid(
    x: Float[np.ndarray, " a"],
    y: Float[np.ndarray, " b"],
    z: Float[np.ndarray, " c"],
    filled: Bool[np.ndarray, "i j k"],
) -> TriangleMesh:
    """Return the surface of the filled cells, with no faces between two of them.

    Neighbours share their vertices, so the mesh is watertight as long as filled cells do not touch along an edge only.

    Args:
        x: Grid planes along x (m), rising.
        y: Grid planes along y (m), rising.
        z: Grid planes along z (m), rising.
        filled: Which cells are solid; one less than the planes along each axis.
    """
    shape = (len(x), len(y), len(z))
    padded = np.pad(filled, 1)
    quads = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            outside = ~np.roll(padded, -sign, axis)[1:-1, 1:-1, 1:-1]
            corner = np.argwhere(filled & outside)
            corner[:, axis] += sign > 0
            u, v = np.eye(3, dtype=int)[[first, second]]
            ring = np.stack([corner, corner + u, corner + u + v, corner + v], axis=1)
            quads.append(ring if sign > 0 else ring[:, ::-1])
    index = np.ravel_multi_index(np.moveaxis(np.concatenate(quads), -1, 0), shape)
    used, faces = np.unique(index[:, [0, 1, 2, 0, 2, 3]], return_inverse=True)
    i, j, k = np.unravel_index(used, shape)
    return TriangleMesh(np.column_stack([x[i], y[j], z[k]]), faces.reshape(-1, 3).astype(np.int32))
