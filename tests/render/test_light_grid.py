from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.render.coarse_scene import returned_fraction
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.light_grid import CoarseScene, lay_grid, sphere_directions
from warehouse_sim.schema import Material, SceneSpec


def test_points_lie_around_what_is_seen_and_rays_end_on_the_nearest_outer_face(wall: SceneSpec) -> None:
    grid = lay_grid(wall)
    fine = grid.levels[0]
    last = fine.origin + (np.array(fine.shape) - 1) * fine.spacing
    views = np.array([view.T_world_camera[:3, 3] for view in wall.viewpoints])
    assert (fine.origin - fine.spacing / 2 < views.min(axis=0)).all()
    assert (last + fine.spacing / 2 > views.max(axis=0)).all()
    assert np.prod(fine.shape) < 10_000
    on_floor = (np.abs(grid.places[:, 2]) < 0.01) & (grid.normals[:, 2] > 0.9)
    assert on_floor.mean() > 0.2
    np.testing.assert_allclose(grid.albedo[on_floor][0], returned_fraction(MATERIALS["concrete"]), atol=1e-6)
    towards = (grid.rays.reshape(-1, 3)[grid.hit] * grid.normals).sum(axis=1)
    assert (towards <= 0.0).all()
    assert np.isfinite(grid.distance.reshape(-1)[grid.hit]).all()


GRID = [(y, z) for y in np.linspace(-0.3, 0.3, 4) for z in np.linspace(-0.3, 0.3, 4)]
SIDES = (-0.3, 0.3)


def sphere_mesh(rings: int = 12) -> TriangleMesh:
    """A ball of radius 0.5 m as the hull of a lattice."""
    points = sphere_directions(20 * rings).astype(float) / 2
    faces = ConvexHull(points).simplices.astype(np.int32)
    a, b, c = np.moveaxis(points[faces], 1, 0)
    inward = (np.cross(b - a, c - a) * a).sum(axis=1) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return TriangleMesh(points, faces)


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


def test_print_on_a_carton_does_not_paint_it_and_open_frames_do_not_close() -> None:
    """A hundred thin dots on a face, and four bars around nothing, are no solid boxes."""
    dot = unit_box()
    spots = [TriangleMesh(dot.vertices * [1e-4, 0.01, 0.01] + [0.0, y, z], dot.faces) for y, z in GRID]
    bars = [TriangleMesh(dot.vertices * [0.05, 0.05, 1.0] + [x, y, 0.0], dot.faces) for x in SIDES for y in SIDES]
    print_model, frame = (box_model(name, (0.6, 0.6, 0.6), "concrete") for name in ("print", "frame"))
    print_model = replace(print_model, parts=(replace(print_model.parts[0], mesh=merge(spots)),))
    frame = replace(frame, parts=(replace(frame.parts[0], mesh=merge(bars * 2)),))
    solid = CoarseScene(make_scene([print_model, frame], [("print", at(0, 0, 0)), ("frame", at(0, 0, 5))]))
    hits = solid.cast(np.array([[-3.0, 0.02, 0.02], [-3.0, 0.02, 5.02]]), np.tile([1.0, 0.0, 0.0], (2, 1)))
    assert np.isinf(hits.distance).all()


def test_a_perforated_upright_is_a_box_of_twelve_faces() -> None:
    """Three sides of a profile of 0.1 m in many plates, as holes leave them: light does not pass between them."""
    plate = unit_box()
    heights = np.linspace(-1.9, 1.9, 12)
    walls = ((0.0, 0.045, 0.1, 0.01), (-0.045, 0.0, 0.01, 0.1), (0.045, 0.0, 0.01, 0.1))
    pieces = [
        TriangleMesh(plate.vertices * [width, depth, 0.2] + [x, y, z], plate.faces)
        for z in heights
        for x, y, width, depth in walls
    ]
    upright = box_model("upright", (0.1, 0.1, 4.0))
    upright = replace(upright, parts=(replace(upright.parts[0], mesh=merge(pieces), scale=np.ones(3)),))
    solid = CoarseScene(make_scene([upright], [("upright", at(0, 0, 0))]))
    between = (heights[4] + heights[5]) / 2
    hits = solid.cast(np.array([[0.02, -3.0, between]]), np.array([[0.0, 1.0, 0.0]]))
    assert hits.distance[0] == pytest.approx(2.95, abs=1e-3)


@pytest.mark.parametrize(("metallic", "roughness"), [(0.0, 0.9), (0.0, 0.4), (1.0, 0.5)])
def test_the_share_that_surfaces_return_is_near_their_colour(metallic: float, roughness: float) -> None:
    """The mirrored part comes on top of what scatters; a rough metal loses a little between its bumps."""
    red, green, blue = returned_fraction(Material("any", (0.6, 0.3, 0.0), roughness, metallic))
    assert 0.6 * (0.7 if metallic else 0.95) < red < 0.7
    assert red > green > blue
    assert blue == pytest.approx(0.03, abs=0.03)
