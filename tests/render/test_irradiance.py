"""Light from the surroundings against what integrating spheres, open skies and lights do by the book."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.render.coarse_scene import returned_fraction
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene, spot
from warehouse_sim.render.irradiance import AXES, FieldLevel, LightGatherer
from warehouse_sim.render.light_grid import lay_grid
from warehouse_sim.render.light_selection import GROUND, direct_irradiance
from warehouse_sim.schema import Light, Material, ObjectInstance, ObjectModel, SceneSpec

FLOOR = box_model("floor", (12, 12, 0.1), "concrete", "floor", 90)


def field_of(scene: SceneSpec) -> FieldLevel:
    """The finest level."""
    return LightGatherer(lay_grid(scene)).field(scene.lights, scene.ambient).levels[0]


def places_of(field: FieldLevel) -> np.ndarray:
    steps = np.stack(np.meshgrid(*map(np.arange, field.weight.shape), indexing="ij"), -1)
    return field.origin + steps * field.spacing


def room(edge: float, albedo: float, lights: list[Light]) -> SceneSpec:
    """A closed cube with inner edge ``edge`` of one grey."""
    thick, middle = 0.2, edge / 2
    paint = {"grey": Material("grey", (albedo,) * 3, 1.0)}
    models: list[ObjectModel] = []
    placed = []
    for axis in range(3):
        size = np.full(3, edge + 2 * thick)
        size[axis] = thick
        models.append(box_model(f"slab{axis}", size, "grey"))
        for side in (-1.0, 1.0):
            centre = np.array([0.0, 0.0, middle])
            centre[axis] += side * (middle + thick / 2)
            placed.append((f"slab{axis}", at(*centre)))
    scene = make_scene(models, placed, lights, materials=paint, ambient=500.0)
    return replace(scene, aisle=(-middle, middle, -middle, middle))


def in_the_room(field: FieldLevel, edge: float) -> np.ndarray:
    inside = (np.abs(places_of(field) - [0, 0, edge / 2]) < edge / 2).all(axis=-1)
    assert np.count_nonzero(inside) > 50
    return inside & (field.weight > 0.5)


def on_walls(field: FieldLevel, edge: float) -> list[float]:
    """Mean irradiance of surfaces that look into the room, at the points nearest to its six walls."""
    place, inside = places_of(field) - [0, 0, edge / 2], in_the_room(field, edge)
    values = []
    for number, axis in enumerate(AXES):
        height = place @ axis
        near = inside & (height < height[inside].min() + 0.01)
        values.append(float(field.irradiance[near][:, number].mean()))
    return values


@pytest.mark.parametrize("albedo", [0.3, 0.6, 0.75])
def test_a_closed_white_box_holds_the_light_of_an_integrating_sphere(albedo: float) -> None:
    """Indirect irradiance of a sphere: flux * rho / (area * (1 - rho)); a cube of few points is within 15 %."""
    edge = 6.0
    light = Light("point", np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, -1.0]), 100.0)
    field = field_of(room(edge, albedo, [light]))
    flux, area = 4.0 * np.pi * 100.0, 6.0 * edge**2
    albedo = returned_fraction(Material("grey", (albedo,) * 3, 1.0))[1]
    assert np.mean(on_walls(field, edge)) == pytest.approx(flux * albedo / (area * (1.0 - albedo)), rel=0.15)


def test_no_sky_comes_into_a_closed_room() -> None:
    field = field_of(room(4.0, 0.5, []))
    assert field.irradiance[in_the_room(field, 4.0)].max() == 0.0
    outside = (np.abs(places_of(field)[..., :2]) > 2.3).any(axis=-1)
    assert (field.weight[outside] < 0.01).all()


def test_the_open_sky_gives_what_the_scene_says() -> None:
    """Far from the only thing there: ``ambient`` from above, the ground's share from below, their mean on walls."""
    scene = make_scene([box_model("box", (0.2, 0.2, 0.2))], [("box", at(0, 0, 0))], ambient=200.0)
    values = field_of(scene).irradiance[..., 1].mean(axis=(0, 1, 2))
    for axis, expected in zip(AXES, (0.65, 0.65, 1.0, 0.65, 0.65, GROUND), strict=True):
        assert values[np.flatnonzero((axis == AXES).all(axis=1))[0]] == pytest.approx(200.0 * expected, rel=0.02)


def test_points_inside_things_are_not_trusted_and_borrow_from_outside() -> None:
    models = [FLOOR, box_model("block", (3, 3, 3))]
    placed = [("floor", at(0, 0, -0.05)), ("block", at(0, 0, 1.5))]
    field = field_of(make_scene(models, placed, [spot((4.0, 0.0, 6.0))], ambient=50.0))
    place = places_of(field)
    inside = (np.abs(place - [0, 0, 1.5]) < 1.4).all(axis=-1)
    assert inside.any()
    assert (field.weight[inside] < 0.01).all()
    assert (field.weight[(np.abs(place[..., :2]) > 3).any(axis=-1)] == 1.0).all()
    assert (field.irradiance[inside].max(axis=(-1, -2)) > 5.0).all()


def test_direct_light_obeys_distance_cone_and_shadow() -> None:
    scene = make_scene([FLOOR, box_model("table", (1, 1, 0.1))], [("floor", at(0, 0, -0.05)), ("table", at(0, 0, 1))])
    solid = lay_grid(scene).solid
    light = replace(spot((0.0, 0.0, 3.0), 900.0), cone_inner=0.5, cone_outer=0.8, color=(1.0, 0.5, 0.0))
    points = np.array([[0, 0, 1.06], [0, 0, 0.01], [0.9, 0, 0.01], [4.0, 0, 0.01]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    got = direct_irradiance(solid, [light], points, up, {})
    assert got[0] == pytest.approx(900.0 / 1.94**2 * np.array([1.0, 0.5, 0.0]), rel=1e-4)
    assert (got[1] == 0.0).all()
    assert got[2, 0] == pytest.approx(900.0 * 2.99 / (2.99**2 + 0.9**2) ** 1.5, rel=1e-4)
    assert (got[3] == 0.0).all()
    bare = direct_irradiance(solid, [replace(light, casts_shadow=False)], points, up, {})
    assert bare[1, 0] == pytest.approx(900.0 / 2.99**2, rel=1e-4)


def test_the_same_scene_has_the_same_bytes_whatever_light_it_had_between(wall: SceneSpec) -> None:
    gatherer = LightGatherer(lay_grid(wall))
    first = gatherer.field(wall.lights, wall.ambient)
    brighter = gatherer.field((*wall.lights, spot((0.0, 0.0, 4.0))), wall.ambient)
    again = gatherer.field(wall.lights, wall.ambient)
    other = LightGatherer(lay_grid(replace(wall, viewpoints=wall.viewpoints[:1]))).field(wall.lights, wall.ambient)
    for number, level in enumerate(first.levels):
        assert brighter.levels[number].irradiance.sum() > 1.01 * level.irradiance.sum()
        assert again.levels[number].irradiance.tobytes() == level.irradiance.tobytes()
        assert other.levels[number].irradiance.tobytes() == level.irradiance.tobytes()


def test_the_coarse_level_knows_what_lies_far_from_the_aisle() -> None:
    """A hall of 40 m lit at one end only: its far wall stays dark, and is not smeared over from the lamp's end."""
    light = replace(spot((0.0, 0.0, 4.0)), cone_inner=0.4, cone_outer=0.6)
    scene = replace(room(40.0, 0.5, [light]), aisle=(-2.0, 2.0, -2.0, 2.0))
    fine, coarse = LightGatherer(lay_grid(scene)).field(scene.lights, 0.0).levels
    assert np.abs(places_of(fine)[..., :2]).max() < 7.0
    assert np.abs(places_of(coarse)[..., :2]).max() == pytest.approx(20.0 - coarse.spacing[0] / 2, abs=0.8)
    assert fine.cut[:, :2].all()
    assert not coarse.cut.any()
    low = coarse.irradiance[:, coarse.irradiance.shape[1] // 2, 0, :, 1].mean(axis=-1)
    middle = len(low) // 2
    assert low[0] < 0.3 * low[middle]
    assert low[-1] < 0.3 * low[middle]


def test_points_do_not_see_through_walls() -> None:
    """Where a point's reach ends, a wall stands: of two rooms one stays dark.

    Not black: points that lie in the wall itself hold the mean of both rooms, and stand for the floor beside them.
    """
    scene = room(6.0, 0.5, [Light("point", np.array([-1.5, 0.0, 3.0]), np.array([0.0, 0.0, -1.0]), 100.0)])
    wall = box_model("wall", (0.1, 6, 6), "grey")
    scene = replace(
        scene,
        models={**scene.models, "wall": wall},
        instances=(
            *scene.instances,
            replace(scene.instances[0], model="wall", instance_id=99, T_world_object=at(0, 0, 3)),
        ),
        aisle=(-3.0, 3.0, -3.0, 3.0),
    )
    field = field_of(scene)
    place, inside = places_of(field), in_the_room(field, 6.0)
    beside = inside & (np.abs(place[..., 0]) < field.spacing[0]) & (np.abs(place[..., 0]) > 0.1)
    way = np.where(place[..., 0] < 0.0, field.reach[..., 0], field.reach[..., 3])[beside]
    to_wall = np.abs(place[..., 0])[beside] - 0.05
    assert (way < to_wall + 0.01).all()  # less where the floor or a side wall is nearer to some rays
    assert np.median(way / to_wall) == pytest.approx(1.0, abs=0.01)
    dark, lit = inside & (place[..., 0] > 0.1), inside & (place[..., 0] < -0.1)
    assert field.irradiance[dark].mean() < 0.02 * field.irradiance[lit].mean()


def test_fill_light_reaches_points_by_the_inverse_square_law_and_not_through_a_plate() -> None:
    lamp = replace(spot((0.0, 0.0, 3.8), 900.0), cone_inner=1.3, cone_outer=1.4, fill=True)
    field = field_of(room(4.0, 0.0, [lamp]))
    place, inside = places_of(field), in_the_room(field, 4.0)
    away = lamp.position - place
    distance = np.linalg.norm(away, axis=-1)
    low = inside & (place[..., 2] < 2.0)
    expected = 900.0 * away[..., 2] / distance**3
    # Points are joined with neighbours, which bends the law where it is steep.
    np.testing.assert_allclose(field.irradiance[low][:, 2, 0], expected[low], rtol=0.15)
    assert field.irradiance[low][:, 5].max() < 1.0

    plated = room(4.0, 0.0, [lamp])
    plate = box_model("plate", (4.0, 4.0, 0.1), "grey")
    shut = replace(
        plated,
        models={**plated.models, "plate": plate},
        instances=(
            *plated.instances,
            ObjectInstance(99, "plate", at(0, 0, 3.0)),
        ),
    )
    below = field_of(shut)
    under = in_the_room(below, 4.0) & (places_of(below)[..., 2] < 2.0)
    assert below.irradiance[under].max() < 1.0


def test_what_shines_far_aside_is_gathered_and_what_a_shadow_map_shows_is_not() -> None:
    """Black walls return nothing: points have what shines beyond 70 deg from its axis, and nothing within 64 deg."""
    lamp = replace(spot((0.0, 0.0, 2.5), 900.0), cone_inner=1.5, cone_outer=1.55)
    field = field_of(room(8.0, 0.0, [lamp]))
    place, inside = places_of(field), in_the_room(field, 8.0)
    away = lamp.position - place
    distance = np.linalg.norm(away, axis=-1)
    angle = np.rad2deg(np.arccos(away[..., 2] / distance))
    far = inside & (angle > 76.0) & (angle < 84.0) & (distance > 2.0)
    assert far.sum() > 30
    expected = 900.0 * np.linalg.norm(away[..., :2], axis=-1) / distance**3
    got = np.linalg.norm(field.irradiance[..., [0, 1, 3, 4], 0], axis=-1)
    assert np.median(got[far] / expected[far]) == pytest.approx(1.0, abs=0.1)
    # Not beside the lamp, where points are joined with such as lie aside of it.
    below = inside & (angle < 40.0) & (distance > 2.0)
    assert below.sum() > 30
    assert field.irradiance[below].max() < 0.05 * np.median(got[far])
