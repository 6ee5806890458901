"""Coarser meshes and the facets that they leave out."""

from itertools import pairwise

import numpy as np
import pytest

from warehouse_sim.catalog.racks.upright import upright_mesh
from warehouse_sim.geometry.detail_levels import detail_levels, facets, parallelograms, plane_regions
from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, merge, sample_surface, unit_box
from warehouse_sim.geometry.solids import prism, unit_cylinder


def plate(x: float, y: float, z: float, thick: float) -> TriangleMesh:
    box = unit_box()
    return TriangleMesh(box.vertices * [0.05, 0.03, thick] + [x, y, z], box.faces)


def distance(points: np.ndarray, mesh: TriangleMesh) -> np.ndarray:
    """Return how far each point is from a mesh, triangle by triangle (Ericson 2005, section 5.1.5, by projection)."""
    best = np.full(len(points), np.inf)
    for a, b, c in mesh.vertices[mesh.faces]:
        normal = np.cross(b - a, c - a)
        weights = np.stack([np.cross(q - p, points - p) @ normal for p, q in ((b, c), (c, a), (a, b))], axis=1) / (
            normal @ normal
        )
        inside = (weights >= 0).all(axis=1)
        flat = np.abs((points - a) @ normal) / np.linalg.norm(normal)
        edges = []
        for p, q in ((a, b), (b, c), (c, a)):
            t = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
            edges.append(np.linalg.norm(points - p - t[:, None] * (q - p), axis=1))
        best = np.minimum(best, np.where(inside, flat, np.min(edges, axis=0)))
    return best


def artwork() -> TriangleMesh:
    star = prism(((0, 0), (0.03, 0), (0.03, 0.01), (0.01, 0.01), (0.01, 0.03), (0, 0.03)), 0.001)
    return merge([plate(0, 0, 0, 0.0005), plate(0.1, 0, 0, 0.0005), plate(0.2, 0, 0, 0.004), star])


@pytest.mark.parametrize("mesh", [artwork(), upright_mesh(1.0)], ids=["artwork", "upright"])
def test_each_level_is_as_near_as_it_says_in_both_directions(mesh: TriangleMesh) -> None:
    levels = detail_levels(mesh)
    assert len(levels) >= 2
    rng = np.random.default_rng(0)
    for level in levels[1:]:
        points, _ = sample_surface(mesh, 3000, rng)
        there = distance(points, level.mesh)
        assert there.max() <= level.error + 1e-9
        assert there.max() > 0.5 * level.error
        back, _ = sample_surface(level.mesh, 500, rng)
        assert distance(back, mesh).max() < 1e-9


def test_levels_get_coarser_and_their_errors_grow() -> None:
    levels = detail_levels(artwork())
    counts = [len(level.mesh.faces) for level in levels]
    errors = [level.error for level in levels]
    assert levels[0].mesh.faces.shape == artwork().faces.shape
    assert errors[0] == 0.0
    assert errors == sorted(set(errors))
    assert all(after <= 0.8 * before for before, after in pairwise(counts))
    assert errors[-1] == pytest.approx(0.002)  # half of the thickest plate
    assert counts[-1] == 4 * 3 + 8  # of each plate the two sides


def test_both_sides_of_a_sheet_stay_exactly_where_they_are() -> None:
    last = detail_levels(merge([plate(0, 0, 0, 0.001), plate(0.1, 0, 0, 0.001)]))[-1].mesh
    assert len(last.faces) == 8
    assert np.unique(last.vertices[last.faces][..., 2]).tolist() == [-0.0005, 0.0005]
    assert sorted(np.unique(last.face_normals()[:, 2]).tolist()) == [-1.0, 1.0]


@pytest.mark.parametrize(
    "mesh",
    [
        unit_cylinder(24),
        grid_box(np.array([1.0, 0.5, 0.2]), 0.02),
        prism(((0, 0), (0.02, 0), (0.02, 0.02), (0, 0.02)), 0.02),
    ],
)
def test_round_and_compact_things_keep_every_face(mesh: TriangleMesh) -> None:
    assert [level.error for level in detail_levels(mesh)] == [0.0]


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
