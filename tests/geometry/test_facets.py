import numpy as np

from warehouse_sim.geometry.detail_levels import facets, parallelograms, plane_regions
from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, unit_box
from warehouse_sim.geometry.solids import prism


def test_a_box_has_six_planes_and_six_parallelograms() -> None:
    found = facets(unit_box())
    pair, turn = parallelograms(found)
    assert found.inner.sum(axis=1).tolist() == [1] * 12
    assert sorted(pair.ravel().tolist()) == list(range(12))
    assert found.inner[pair, turn].all()
    assert np.bincount(plane_regions(found)).tolist() == [2] * 6


def test_neighbours_see_each_other() -> None:
    for mesh in (unit_box(), grid_box(np.array([1.0, 0.5, 0.2]), 0.1), prism(((0, 0), (2, 0), (1, 0.5), (0, 2)), 0.1)):
        found = facets(mesh)
        assert (found.across >= 0).all()
        here = np.arange(found.across.size).reshape(found.across.shape)
        assert np.array_equal(found.across.ravel()[found.across], here)
        kept = found.partner >= 0
        assert np.array_equal(found.partner[kept], found.across[kept])


def test_an_edge_of_three_sheets_has_no_one_on_the_other_side() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], float)
    found = facets(TriangleMesh(points, np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]], np.int32)))
    assert (found.across == -1).all()
    assert found.inner.sum() == 2  # the two triangles in the plane z = 0 still share their edge
    assert plane_regions(found).tolist() == [0, 1, 0]
