"""Finer triangles for a renderer that computes light at vertices only."""

import numpy as np

from warehouse_sim.render.painted_mesh import PaintedMesh

_AFTER = np.array([1, 2, 0])
_SMALL = 2.0
"""Meshes that are nowhere this wide (m) are lit well enough at their corners."""
_STEPS = 32
"""Triangle edges along the longest side of a wide mesh."""
_MANY_FACES = 1000
"""Meshes of more faces are left alone: they are corrugated or perforated, and would become very many."""


def lit_at_vertices(mesh: PaintedMesh) -> PaintedMesh:
    """Return ``mesh`` with enough vertices that a light over the middle of a floor or a wall lights it."""
    extent = np.sort(np.ptp(mesh.positions, axis=0))
    if extent[1] < _SMALL or len(mesh.faces) > _MANY_FACES:
        return mesh
    return tessellate(mesh, max(float(extent[2]) / _STEPS, 1.0))


def tessellate(mesh: PaintedMesh, longest: float) -> PaintedMesh:
    """Return ``mesh`` with triangles whose edges are at most ``longest`` (m), by bisecting longest edges.

    Whether and where an edge is cut depends on nothing but its ends, so that neighbours stay without gaps.
    """
    positions, normals, tiles, faces = mesh.positions, mesh.normals, mesh.tiles, mesh.faces
    while True:
        corners = positions[faces]
        lengths = np.linalg.norm(corners[:, _AFTER] - corners, axis=2)  # of the edges that start at each corner
        cut = np.flatnonzero(lengths.max(axis=1) > longest)
        if len(cut) == 0:
            return PaintedMesh(positions, normals, tiles, faces)
        start = lengths[cut].argmax(axis=1)
        a, b = faces[cut, start], faces[cut, _AFTER[start]]
        opposite = faces[cut, _AFTER[_AFTER[start]]]
        middle = (len(positions) + np.arange(len(cut))).astype(np.int32)
        positions = np.concatenate([positions, (positions[a] + positions[b]) / 2])
        tiles = np.concatenate([tiles, (tiles[a] + tiles[b]) / 2])
        normals = np.concatenate([normals, normals[a]])  # flat: equal at all three corners
        kept = np.delete(faces, cut, axis=0)
        halves = [np.stack(corners, axis=1) for corners in ((a, middle, opposite), (middle, b, opposite))]
        faces = np.concatenate([kept, *halves])
