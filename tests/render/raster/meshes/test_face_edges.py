import numpy as np
import pytest

from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, unit_box
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.render.raster.meshes.mesh_levels import flat_mesh


def rendered_normals(mesh: TriangleMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return twice the area vector of each drawn triangle and the normal that its first corner holds."""
    flat = flat_mesh(mesh)
    a, b, c = np.moveaxis(flat.corners["position"][flat.triangles].astype(float), 1, 0)
    return np.cross(b - a, c - a), flat.corners["normal"][flat.triangles[:, 0]]


def test_a_box_needs_24_corners_and_each_edge_is_zero_on_itself() -> None:
    flat = flat_mesh(unit_box())
    assert len(flat.corners) == 24
    assert flat.triangles.shape == (12, 3)
    for normal in np.unique(flat.corners["normal"], axis=0):
        face = flat.corners[(flat.corners["normal"] == normal).all(axis=1)]
        # Four corners of a face: each lies on two of its edges, each edge holds two corners.
        assert (np.count_nonzero(face["to_edge"] == 0, axis=1) == 2).all()
        assert (np.count_nonzero(face["to_edge"] == 0, axis=0) == 2).all()


@pytest.mark.parametrize("mesh", [unit_box(), unit_cylinder(24), grid_box(np.array([1.0, 0.5, 0.2]), 0.1)])
def test_the_surface_stays_the_same(mesh: TriangleMesh) -> None:
    crosses, normals = rendered_normals(mesh)
    assert np.linalg.norm(crosses, axis=1).sum() / 2 == pytest.approx(mesh.face_areas().sum(), rel=1e-6)
    unit = crosses / np.linalg.norm(crosses, axis=1, keepdims=True)
    np.testing.assert_allclose(unit, normals, atol=2e-6)


def test_lines_between_coplanar_triangles_are_no_edges() -> None:
    """Every edge of a box that is cut into a grid lies on the outline of the box."""
    size = np.array([1.0, 0.5, 0.2])
    flat = flat_mesh(grid_box(size, 0.1))
    corner = np.abs(flat.corners["position"]) > size / 2 - 1e-6
    inside_face = corner.sum(axis=1) == 1
    assert inside_face.any()
    assert (flat.corners["to_edge"][inside_face] > 0).all()
    on_outline = corner.sum(axis=1) >= 2
    assert (flat.corners["to_edge"][on_outline] == 0).any(axis=1).mean() > 0.8


def test_triangles_without_area_are_left_out() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    flat = flat_mesh(TriangleMesh(points, np.array([[0, 1, 2], [0, 1, 3]], np.int32)))
    assert len(flat.triangles) == 1
    assert flat.corners["to_edge"].tolist().count([0, 0, 0, 255]) == 0
    assert sorted(flat.corners["to_edge"].tolist()) == [[0, 0, 255, 255], [0, 255, 0, 255], [255, 0, 0, 255]]
