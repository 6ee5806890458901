from dataclasses import replace

import numpy as np
import pytest
from jaxtyping import Float32
from scipy.spatial import ConvexHull

from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.coarse_scene import returned_fraction
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.hall_probe import COLUMNS, ROUGHNESS, ROWS
from warehouse_sim.render.irradiance import LightGatherer
from warehouse_sim.render.light_grid import CoarseScene, lay_grid, sphere_directions
from warehouse_sim.render.light_selection import facing_illuminance, point_ahead, reference_points, strongest_lights
from warehouse_sim.schema import Material, SceneSpec, Viewpoint


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


# What a hall looks like in all directions: more than six directions know, and no more light in all.


def probe_of_room() -> Float32[np.ndarray, "levels rows columns"]:
    """A room of black walls but for the one at +x, seen from its middle."""
    sides = {"bright": (0.2, 8, 6), "dark": (0.2, 8, 6), "end": (12, 0.2, 6), "flat": (12, 8, 0.2)}
    models = [
        box_model(name, size, "bright" if name == "bright" else "black", "wall", number)
        for number, (name, size) in enumerate(sides.items(), 90)
    ]
    placed = [("bright", at(6, 0, 3)), ("dark", at(-6, 0, 3))]
    placed += [("end", at(0, y, 3)) for y in (-4, 4)] + [("flat", at(0, 0, z)) for z in (0, 6)]
    paint = {"bright": Material("bright", (0.8,) * 3), "black": Material("black", (0.02,) * 3)}
    lamp = replace(spot((0.0, 0.0, 5.5), 2000.0), kind="point", casts_shadow=False)
    scene = make_scene(models, placed, [lamp], materials={**MATERIALS, **paint}, ambient=0.0)
    return LightGatherer(lay_grid(scene)).field(scene.lights, scene.ambient).probe


def test_a_smooth_surface_mirrors_one_bright_wall_and_a_matt_one_hardly_knows_it() -> None:
    found = probe_of_room()
    assert found.shape == (len(ROUGHNESS), ROWS, COLUMNS)
    level = found[:, ROWS // 2]
    ahead, beside = level[:, [0, -1]].mean(axis=1), level[:, COLUMNS // 4]
    assert ahead[0] > 1.2
    assert beside[0] < 0.7
    assert np.all(np.diff(ahead - beside) < 0.0)
    assert abs(ahead[-1] - 1.0) < 0.1


def test_where_there_is_nothing_all_directions_are_alike() -> None:
    scene = make_scene(
        [box_model("floor", (1, 1, 0.1), "concrete", "floor", 90)], [("floor", at(0, 0, -0.05))], [], ambient=0.0
    )
    found = LightGatherer(lay_grid(scene)).field((), 0.0).probe
    assert found == pytest.approx(1.0)


def test_the_lights_kept_are_those_that_light_the_place_the_most_in_their_order() -> None:
    lights = [spot((x, 0, 5), 1000.0) for x in (-20, 4, 60)] + [spot((30, 0, 5), 1e6)]
    place = point_ahead(level_camera(np.array([0.0, 0, 1.5]), 0.0))
    assert strongest_lights(lights, None, place) == lights
    assert strongest_lights(lights, 2, place) == [lights[1], lights[3]]
    assert strongest_lights(lights[:3], 1, point_ahead(level_camera(np.array([0.0, 0, 1.5]), np.pi))) == [lights[1]]
    assert strongest_lights(lights[:3], 1, place - [30.0, 0, 0]) == [lights[0]]


def test_a_scene_is_looked_at_for_its_aisle_or_its_targets_or_what_its_lights_light() -> None:
    models = [box_model("floor", (9, 9, 0.1)), box_model("pallet", (1, 1, 1), class_name="pallet")]
    scene = make_scene(models, [("floor", at(0, 0, 0)), ("pallet", at(3, 1, 0))], [spot((0, 0, 6))])
    np.testing.assert_allclose(reference_points(scene), [[3, 1, 0]])
    np.testing.assert_allclose(reference_points(replace(scene, instances=scene.instances[:1])), [[0, 0, 2]])
    places = reference_points(replace(scene, aisle=(-4.0, 4.0, -3.0, 0.0)))
    np.testing.assert_allclose(places[:, :2].mean(axis=0), [0.0, -1.5], atol=1e-9)
    assert len(np.unique(places[:, 0])) == 4
    assert (places[:, 2] > 0.0).all()
    assert np.array_equal(reference_points(replace(scene, viewpoints=(Viewpoint(np.eye(4)),))), reference_points(scene))


def test_a_spot_gives_its_intensity_over_the_square_of_the_distance_within_its_cone() -> None:
    light = replace(spot((0, 0, 5), 900.0), cone_inner=0.3, cone_outer=0.6)
    points = np.array([[0, 0, 2.0], [0, 0, 8.0], [4, 0, 2.0]])
    np.testing.assert_allclose(facing_illuminance(light, points), [100.0, 0.0, 0.0])
    middle = np.arccos((np.cos(0.3) + np.cos(0.6)) / 2)
    rim = np.array([[3 * np.tan(middle), 0, 2.0]])
    assert facing_illuminance(light, rim)[0] == pytest.approx(900 / (3 / np.cos(middle)) ** 2 / 4)
