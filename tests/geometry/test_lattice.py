import numpy as np
import pytest

from warehouse_sim.catalog.pallets.moulded import lattice_solid
from warehouse_sim.geometry.mesh import TriangleMesh

X, Y, Z = np.array([0.0, 1.0, 1.5, 4.0]), np.array([-1.0, 0.0, 2.0, 2.5]), np.array([0.0, 0.5])


def volume(mesh: TriangleMesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_a_hole_has_walls_and_the_surface_is_closed() -> None:
    filled = np.ones((3, 3, 1), dtype=bool)
    filled[1, 1, 0] = False
    mesh = lattice_solid(X, Y, Z, filled)
    assert volume(mesh) == pytest.approx((4.0 * 3.5 - 0.5 * 2.0) * 0.5)
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    assert len({tuple(edge) for edge in edges}) == len(edges)
    assert all([b, a] in edges for a, b in edges)
    # Euler characteristic of a ring: 0.
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.faces) == 0


def test_only_used_grid_points_become_vertices() -> None:
    filled = np.zeros((3, 3, 1), dtype=bool)
    filled[2, 0, 0] = True
    mesh = lattice_solid(X, Y, Z, filled)
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    np.testing.assert_array_equal(mesh.vertices.min(axis=0), [1.5, -1.0, 0.0])
    np.testing.assert_array_equal(mesh.vertices.max(axis=0), [4.0, 0.0, 0.5])
