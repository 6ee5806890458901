from dataclasses import replace

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.to_size import rooflight, window_band
from warehouse_sim.catalog.materials import materials
from warehouse_sim.generation.light.dimming import FLUX, HEIGHT, work_lights
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z, transform_points
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig
from warehouse_sim.scene.lighting.daylight import PANE, pane_lights
from warehouse_sim.scene.lighting.luminaires import add_doors, hang_luminaires, luminaires_of
from warehouse_sim.scene.lighting.photometry import luminous_flux
from warehouse_sim.scene.lighting.switching import sample_lighting
from warehouse_sim.schema import LuminousFace, SceneSpec, Viewpoint

AISLE, HALL = Area(-4.0, 4.0, -8.0, 0.0), Area(-23.8, 23.8, -23.8, 1.5)


def sampled(draft: SceneDraft) -> SceneSpec:
    return SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), ())


def test_luminaires_hang_in_rows_over_the_aisle_each_with_a_face_of_its_own() -> None:
    draft = SceneDraft()
    hang_luminaires(draft, 2, 2, 6.0, AISLE)
    places = [item.T_world_object[:3, 3] for item in draft.instances]
    np.testing.assert_allclose(places, [[-2, -2, 6], [2, -2, 6], [-2, -6, 6], [2, -6, 6]])
    luminaires = luminaires_of(sampled(draft))
    assert len({item.face.material for item in luminaires}) == 4
    for item, place, instance in zip(luminaires, places, draft.instances, strict=True):
        assert item.face.source == "electric"
        assert item.face.material in {part.material for part in draft.models[instance.model].parts}
        np.testing.assert_allclose(item.position[:2], place[:2])
        assert item.position[2] < place[2] - draft.models[instance.model].size[2] / 2
        np.testing.assert_allclose(item.direction, [0, 0, -1])


def test_light_comes_out_of_whatever_has_a_luminous_face() -> None:
    """Of an object whose name says nothing, turned and moved; and of nothing else."""
    draft = SceneDraft()
    face = LuminousFace("electric", "opal", "opal", np.array([0.0, 1.0, 0.0]), 0.1, 0.5)
    model = replace(catalog_object("epal1"), name="somebody's", luminous_face=face)
    draft.add(model, make_transform(rotation_z(np.pi / 2), np.array([1.0, 2.0, 3.0])))
    draft.add("column_guard", np.eye(4))
    (found,) = luminaires_of(sampled(draft))
    assert found.face is face
    np.testing.assert_allclose(found.direction, [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.position, [1.12, 2.0, 3.0])


def test_one_door_ends_the_aisle_and_one_is_beside_what_stands_along_the_front() -> None:
    draft = SceneDraft()
    add_doors(draft, AISLE, HALL)
    end, front = luminaires_of(sampled(draft))
    np.testing.assert_allclose(end.direction, [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(front.direction, [0, -1, 0], atol=1e-12)
    assert end.position[1] == -4.0
    assert 23.5 < end.position[0] < 23.8
    assert front.position[0] - 2.1 >= AISLE.x_max
    for instance in draft.instances:
        points = transform_points(instance.T_world_object, draft.models[instance.model].mesh().vertices)
        assert points[:, 2].min() == pytest.approx(0.0)
        assert points[:, 0].max() <= HALL.x_max + 1e-9
        assert points[:, 1].max() <= HALL.y_max + 1e-9


@pytest.mark.parametrize("columns", ["steel", "concrete"])
@pytest.mark.parametrize("bays", [1, 4, 12])
def test_doors_keep_off_columns_and_racks(bays: int, columns: str) -> None:
    draft, rng = SceneDraft(), np.random.default_rng(0)
    site = build_site(draft, RackAisleConfig(bays=bays), HallConfig(columns=columns), rng)  # type: ignore[arg-type]
    before = len(draft.instances)
    add_doors(draft, site.aisle, site.hall)
    solids = draft.solids()
    doors = solids.boxes.subset(solids.owner > before)
    others = solids.boxes.subset((solids.owner <= before) & (solids.boxes.half.max(axis=1) < 20.0))
    pairs = np.array([(a, b) for a in range(len(doors.centre)) for b in range(len(others.centre))])
    assert doors.separation(others, pairs).distance.min() > 0.0


@pytest.mark.parametrize("bays", [2, 4, 5, 9])
def test_luminaires_hang_beside_the_trusses_of_a_roof(bays: int) -> None:
    draft, site = built(RackAisleConfig(bays=bays), roof=True)
    before = len(draft.instances)
    hang_luminaires(draft, 1, 4, 8.0, site.aisle)
    trusses = [item.T_world_object[0, 3] for item in draft.instances if item.model == "roof_truss"]
    assert len(trusses) == 4
    for item in draft.instances[before:]:
        assert min(abs(item.T_world_object[0, 3] - x) for x in trusses) >= 0.9 - 1e-9  # 0.6 is half a luminaire


def test_two_lights_on_the_guard_of_the_vehicle_shine_ahead_and_down() -> None:
    T_world_vehicle = make_transform(rotation_z(0.5), np.array([1.0, 2.0, 0.0]))
    camera = level_camera(np.array([1.5, 2.3, 0.4]), 0.5, 0.0)
    lights = work_lights(Viewpoint(camera, T_world_vehicle=T_world_vehicle), 5000.0)
    middle = np.mean([light.position for light in lights], axis=0)
    np.testing.assert_allclose(middle, [1.0, 2.0, HEIGHT])
    assert np.linalg.norm(lights[0].position - lights[1].position) == pytest.approx(0.9)
    for light in lights:
        assert light.direction[:2] @ [np.cos(0.5), np.sin(0.5)] > 0.9
        assert -0.3 < light.direction[2] < 0.0
        assert np.linalg.norm(light.direction) == pytest.approx(1.0)
        assert luminous_flux(light) == pytest.approx(FLUX)
        assert light.casts_shadow


def test_a_camera_that_nothing_carries_is_lit_from_above_itself() -> None:
    pitched = level_camera(np.array([3.0, -1.0, 0.6]), 2.0, -0.4)
    lights = work_lights(Viewpoint(pitched), 5000.0)
    np.testing.assert_allclose(np.mean([light.position for light in lights], axis=0), [3.0, -1.0, HEIGHT])
    assert all(light.direction[:2] @ [np.cos(2.0), np.sin(2.0)] > 0.9 for light in lights)


# Panes of rooflights and windows send what they show into the hall.


FLOOR = np.array([[0.0, 0.0, 0.0]])


def hall(strips: int = 20) -> SceneSpec:
    draft = SceneDraft()
    for x in np.arange(strips) * 3.0:
        draft.add(rooflight(6.0), make_transform(translation=np.array([x, 0.0, 8.0])))
    draft.add(window_band(6.0), make_transform(rotation_z(np.pi / 2), np.array([-5.0, 0.0, 5.0])))
    return SceneSpec(0, 0, draft.models, materials(), tuple(draft.instances), (), ())


def test_they_give_the_flux_of_lambertian_panes() -> None:
    """Flux is pi L A; bars cover about a seventh of strips and bands."""
    pane = materials()[PANE]
    luminance = pane.emission * float(np.array(pane.base_color) @ [0.2126, 0.7152, 0.0722])
    flux = sum(luminous_flux(light) for light in pane_lights(hall(), PRESETS["nominal"]))
    assert flux == pytest.approx(np.pi * luminance * (20 * 6.0 * 1.6 + 6.0 * 1.2) * 0.85, rel=1e-3)


def test_few_lights_stand_for_all_before_their_panes_and_look_into_the_hall() -> None:
    lights = pane_lights(hall(), PRESETS["nominal"])
    down = [light for light in lights if light.direction[2] == -1.0]
    (aside,) = [light for light in lights if light.direction[2] == 0.0]
    assert len(down) == 8
    assert all(light.fill and light.position[2] < 8.0 for light in down)
    np.testing.assert_allclose(aside.direction, [1.0, 0.0, 0.0], atol=1e-6)
    assert aside.position[0] > -5.0


def test_at_dusk_they_give_less_and_at_night_nothing() -> None:
    day, dusk = (sum(map(luminous_flux, pane_lights(hall(), PRESETS[name]))) for name in ("nominal", "dim"))
    assert 0.05 * day < dusk < 0.2 * day
    assert pane_lights(hall(), PRESETS["night"]) == ()


def test_what_panes_show_is_scaled_with_what_they_give() -> None:
    lighting = sample_lighting(LightingConfig(daylight=True), hall(), FLOOR, np.random.default_rng(0))
    lit = lighting.scaled(0.25).applied(hall())
    assert lit.materials[PANE].emission == pytest.approx(0.25 * materials()[PANE].emission)
    only_glowing = sample_lighting(LightingConfig(), hall(), FLOOR, np.random.default_rng(0)).scaled(0.25)
    assert only_glowing.fill == ()
    assert only_glowing.applied(hall()).materials[PANE] == materials()[PANE]


def test_lighting_a_lit_scene_again_changes_nothing_outdoors() -> None:
    """Dusk is a ninth of the day, and not of the dusk before."""
    config = replace(LightingConfig(), preset="dim")
    once = sample_lighting(config, hall(), FLOOR, np.random.default_rng(0)).applied(hall())
    twice = sample_lighting(config, once, FLOOR, np.random.default_rng(0)).applied(once)
    assert twice.materials[PANE] == once.materials[PANE]
    assert once.materials[PANE].emission < 0.2 * materials()[PANE].emission
