from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.light_grid import CoarseScene, lay_grid, sphere_directions
from warehouse_sim.schema import Material, SceneSpec


def test_directions_are_unit_and_spread_evenly() -> None:
    rays = sphere_directions(64)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, atol=1e-6)
    assert np.abs(rays.mean(axis=0)).max() < 0.01
    np.testing.assert_allclose(rays.T @ rays / 64, np.eye(3) / 3, atol=0.01)
    nearest = np.sort(rays @ rays.T, axis=1)[:, -2]
    assert np.degrees(np.arccos(nearest)).min() > 15.0


def test_points_lie_around_what_is_seen_and_rays_end_on_the_nearest_outer_face(wall: SceneSpec) -> None:
    grid = lay_grid(wall)
    last = grid.origin + (np.array(grid.shape) - 1) * grid.spacing
    views = np.array([view.T_world_camera[:3, 3] for view in wall.viewpoints])
    assert (grid.origin < views.min(axis=0)).all()
    assert (last > views.max(axis=0)).all()
    assert np.prod(grid.shape) < 5000
    on_floor = (np.abs(grid.places[:, 2]) < 0.01) & (grid.normals[:, 2] > 0.9)
    assert on_floor.mean() > 0.2
    np.testing.assert_allclose(grid.albedo[on_floor][0], MATERIALS["concrete"].base_color, atol=1e-6)
    towards = (grid.rays.reshape(-1, 3)[grid.hit] * grid.normals).sum(axis=1)
    assert (towards <= 0.0).all()
    assert not grid.escaped.reshape(-1)[grid.hit].any()


def sphere_mesh(rings: int = 12) -> TriangleMesh:
    """A ball of radius 0.5 m as the hull of a lattice."""
    points = sphere_directions(20 * rings).astype(float) / 2
    return TriangleMesh(points, ConvexHull(points).simplices.astype(np.int32))


def test_small_round_parts_are_boxes_tiny_ones_and_film_are_nothing() -> None:
    ball = box_model("ball", (0.8, 0.8, 0.8))
    ball = replace(ball, parts=(replace(ball.parts[0], mesh=sphere_mesh()),))
    models = [ball, box_model("nail", (0.05, 0.05, 0.05)), box_model("wrap", (1, 1, 1), "film")]
    materials = {**MATERIALS, "film": Material("film", (0.8, 0.8, 0.8), opacity=0.3)}
    placed = [("ball", at(0, 0, 0)), ("nail", at(0, 0, -2)), ("wrap", at(0, 0, 2))]
    solid = CoarseScene(make_scene(models, placed, materials=materials))
    origins = np.array([[-3.0, 0.38, 0.38], [-3.0, 0.0, -2.0], [-3.0, 0.0, 2.0]])
    hits = solid.cast(origins, np.tile([1.0, 0.0, 0.0], (3, 1)))
    assert hits.distance[0] == pytest.approx(2.6, abs=0.01)  # the corner of the ball's box
    assert np.isinf(hits.distance[1:]).all()
    assert (hits.albedo[1:] == 0.0).all()
    assert solid.blocked(origins[:1], np.array([[1.0, 0, 0]]), 3.0).all()
    assert not solid.blocked(origins[:1], np.array([[1.0, 0, 0]]), 2.0).any()
