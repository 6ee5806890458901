import numpy as np
import pytest
import trimesh

from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, split_long_edges, unit_box


def edge_lengths(mesh: TriangleMesh) -> np.ndarray:
    corners = mesh.vertices[mesh.faces]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


@pytest.mark.parametrize("spacing", [10.0, 0.5, 0.11, 0.05])
def test_grid_box_is_the_same_solid(spacing: float) -> None:
    size = np.array([1.2, 0.145, 0.022])
    mesh = grid_box(size, spacing)
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert solid.is_watertight
    assert solid.volume == pytest.approx(size.prod(), rel=1e-12)
    assert solid.area == pytest.approx(2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]), rel=1e-12)
    assert np.allclose(solid.bounds, [-size / 2, size / 2], rtol=0, atol=1e-15)
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    # Each triangle is half of a grid cell, whose sides are at most the spacing.
    assert edge_lengths(mesh).max() <= spacing * np.sqrt(2) + 1e-12 or spacing > size.max()


@pytest.mark.parametrize("longest", [0.7, 0.2, 0.09])
def test_split_long_edges_keeps_the_solid(longest: float) -> None:
    box = TriangleMesh(unit_box().vertices * [1.3, 0.4, 0.1], unit_box().faces)
    mesh = split_long_edges(box, longest)
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert edge_lengths(mesh).max() <= longest
    assert solid.is_watertight
    assert solid.volume == pytest.approx(1.3 * 0.4 * 0.1, rel=1e-12)
    assert solid.area == pytest.approx(box.face_areas().sum(), rel=1e-12)
