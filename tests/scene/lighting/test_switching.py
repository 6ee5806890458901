from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.building.to_size import light_line
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.resources import find_photometry
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig, PresetName
from warehouse_sim.scene.lighting.hall_light import fill_lights
from warehouse_sim.scene.lighting.ies_file import load_distribution
from warehouse_sim.scene.lighting.luminaires import add_doors, hang_luminaires
from warehouse_sim.scene.lighting.photometry import luminous_flux, unshadowed_illuminance
from warehouse_sim.scene.lighting.switching import SceneLighting, sample_lighting
from warehouse_sim.schema import Light, SceneSpec

AISLE = Area(-6.0, 6.0, -8.0, 0.0)
FLOOR = np.array([(x, y, 0.0) for x in np.linspace(-5, 5, 6) for y in np.linspace(-7, -1, 4)])


def hall(rows: int = 1, count: int = 4) -> SceneSpec:
    draft = SceneDraft()
    hang_luminaires(draft, rows, count, 7.0, AISLE)
    add_doors(draft, AISLE, Area(-23.8, 23.8, -23.8, 1.5))
    return SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), ())


def installed(rows: int = 1, count: int = 4, seed: int = 0, **settings: object) -> SceneLighting:
    config = LightingConfig(**settings)  # type: ignore[arg-type]
    return sample_lighting(config, hall(rows, count), FLOOR, np.random.default_rng(seed))


def fluxes(lighting: SceneLighting, source: str) -> list[float]:
    """Of each luminaire with that source (lm)."""
    pairs = zip(lighting.luminaires, lighting.lights, strict=True)
    return [luminous_flux(light) if light else 0.0 for item, light in pairs if item.face.source == source]


def test_given_flux_is_the_flux_of_every_luminaire_and_is_not_scaled() -> None:
    lit = installed(flux=Distribution.constant(12000.0))
    assert lit.lux is None
    assert fluxes(lit, "electric") == pytest.approx([12000.0] * 4)
    assert fluxes(lit, "daylight") == [0.0, 0.0]


def test_which_lights_burn_tells_presets_apart() -> None:
    full = 15000.0
    assert fluxes(installed(preset="nominal"), "electric") == pytest.approx([full] * 4)
    assert fluxes(installed(preset="dim"), "electric") == pytest.approx([full, 0, full, 0])
    assert fluxes(installed(preset="harsh"), "electric") == pytest.approx([full, 0, 0, full])
    assert fluxes(installed(preset="night"), "electric")[1:3] == [0, 0]
    backlit = installed(preset="backlit")
    assert min(fluxes(backlit, "daylight")) > 10 * max(fluxes(backlit, "electric"))
    assert {name for name in PRESETS if installed(preset=name).preset.headlights} == {"night"}


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
def test_of_failing_luminaires_some_are_dark_one_flickers_and_one_is_whole(count: int) -> None:
    lit = [installed(count=count, seed=seed, preset="failing") for seed in range(9)]
    sampled = {tuple(np.round(fluxes(item, "electric"), 6)) for item in lit}
    for each in sampled:
        assert each.count(3750.0) == 1
        assert each.count(15000.0) >= (count > 1)
        assert each.count(0.0) == max(0, min(max(round(0.45 * count), 1), count - 2))
    assert len(sampled) == 1 if count == 1 else len(sampled) > 1


@pytest.mark.parametrize("rows", [1, 2])
def test_mixed_luminaires_are_warm_and_cold_by_row_or_in_turn(rows: int) -> None:
    lights = installed(rows=rows, count=2, preset="mixed_colour").switched_on
    warm = [light.color[0] > light.color[2] for light in lights]
    by_row = [warm[index] for index in np.argsort([light.position[1] for light in lights], kind="stable")]
    assert sum(warm) == len(warm) / 2
    if rows == 2:
        assert by_row[0] == by_row[1] != by_row[2] == by_row[3]
    else:
        assert warm[0] != warm[1]


def test_harsh_luminaires_lean_along_the_aisle_to_both_ends() -> None:
    axes = np.array([light.direction for light in installed(preset="harsh").switched_on])
    np.testing.assert_allclose(np.linalg.norm(axes, axis=1), 1.0)
    np.testing.assert_allclose(axes[:, 1], 0.0, atol=1e-12)
    assert axes[0, 0] == pytest.approx(-axes[1, 0])


def test_an_open_door_sends_the_luminance_of_the_sky_times_its_area() -> None:
    lit = installed(preset="backlit")
    pairs = zip(lit.luminaires, lit.lights, strict=True)
    door, light = next((item, light) for item, light in pairs if item.face.source == "daylight")
    assert light is not None
    assert light.intensity == pytest.approx(PRESETS["backlit"].sky_luminance * 3.8 * 4.2)
    np.testing.assert_allclose(light.direction, door.direction)


def test_even_light_is_a_share_of_the_luminaires_and_all_is_scaled_together() -> None:
    lit = installed(ambient_fraction=0.5)
    up = np.tile([0.0, 0.0, 1.0], (len(FLOOR), 1))
    assert lit.ambient == pytest.approx(0.5 * unshadowed_illuminance(lit.switched_on, FLOOR, up).mean())
    twice = lit.scaled(2.0)
    assert twice.ambient == 2.0 * lit.ambient
    assert [light.intensity for light in twice.switched_on] == [2.0 * light.intensity for light in lit.switched_on]


def test_luminaires_that_are_off_emit_nothing_and_others_emit_their_colour() -> None:
    scene = hall()
    for name in PRESETS:
        lit = installed(preset=name)
        applied = lit.applied(scene)
        assert applied.lighting == name
        assert applied.instances is scene.instances
        assert applied.models is scene.models
        for item, light in zip(lit.luminaires, lit.lights, strict=True):
            material = applied.materials[item.face.material]
            assert (material.emission > 0.0) == (light is not None)
            if light is not None:
                np.testing.assert_allclose(material.base_color, np.array(light.color) / max(light.color))
    flickering = installed(preset="failing").applied(scene)
    glowing = [
        flickering.materials[item.face.material].emission for item in lit.luminaires if item.face.source == "electric"
    ]
    shown = sorted(set(np.round(glowing, 6)))
    assert len(shown) == 3
    assert shown[1] == pytest.approx(0.25 * shown[2])


def test_a_photometric_file_gives_its_own_lumens_where_they_are_requested_for() -> None:
    distribution = load_distribution(find_photometry("aisle_narrow"))
    own = installed(photometry="aisle_narrow", photometry_flux=True)
    assert own.lux is None
    assert fluxes(own, "electric") == pytest.approx([distribution.peak * distribution.flux_per_candela] * 4)
    wanted = installed(photometry="aisle_narrow")
    assert wanted.lux is not None
    assert fluxes(wanted, "electric") == pytest.approx([15000.0] * 4)


def test_luminaires_of_a_file_lie_along_their_bodies_and_doors_have_none() -> None:
    lit = installed(photometry="aisle_narrow", preset="backlit")
    for item, light in zip(lit.luminaires, lit.lights, strict=True):
        if light is None:
            continue
        assert (light.distribution is None) == (item.face.source == "daylight")
        if light.distribution is not None:
            assert np.abs(np.dot(light.along, item.length)) == pytest.approx(1.0)


# Rows of light beside the aisle give the hall's floor what is requested.


WHITE = (1.0, 1.0, 1.0)


def hall_of(rows: int, length: float = 46.0) -> SceneSpec:
    draft = SceneDraft()
    for y in (np.arange(rows) - (rows - 1) / 2) * 6.0:
        draft.add(light_line(length), make_transform(translation=np.array([0.0, y, 7.5])))
    return SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), ())


def filled(scene: SceneSpec, lux: float, preset: PresetName = "nominal", seed: int = 0) -> tuple[Light, ...]:
    return fill_lights(scene, lux, [WHITE], PRESETS[preset], np.random.default_rng(seed))


@pytest.mark.parametrize("rows", [4, 7])
def test_the_floor_under_the_rows_gets_the_lux_over_what_is_lost_on_the_way(rows: int) -> None:
    lights = filled(hall_of(rows), 200.0)
    x, y = np.meshgrid(np.linspace(-15, 15, 31), np.linspace(-1, 1, 5) * 3.0 * (rows - 2))
    floor = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    lux = unshadowed_illuminance(lights, floor, np.tile([0.0, 0.0, 1.0], (len(floor), 1)))
    # Without walls and goods nothing is lost but what falls beyond the rows: between the wanted lux and that over 0.6.
    assert 200.0 < lux.mean() < 200.0 / 0.6 * 1.05
    assert lux.min() > 0.7 * lux.mean()


def test_they_are_few_and_all_fill() -> None:
    lights = filled(hall_of(9), 100.0)
    assert 9 <= len(lights) <= 30
    assert all(light.fill and light.direction[2] == -1.0 for light in lights)


def test_a_hall_without_rows_or_with_dark_ones_has_none() -> None:
    assert filled(hall_of(0), 200.0) == ()
    assert filled(hall_of(3), 0.0) == ()


def test_rows_take_the_colours_of_the_luminaires_in_turn() -> None:
    warm = (1.3, 0.9, 0.5)
    lights = fill_lights(hall_of(4), 100.0, [WHITE, warm], PRESETS["mixed_colour"], np.random.default_rng(0))
    by_row = {round(float(light.position[1]), 2): light.color for light in lights}
    assert [by_row[y] for y in sorted(by_row, key=abs)] == [WHITE, warm, WHITE, warm]


def test_rows_and_what_hangs_in_them_are_dark_in_the_pattern_of_the_preset() -> None:
    """Of every third luminaire of every third row comes a ninth of the light, in beams that lean both ways."""
    all_on, harsh = filled(hall_of(6), 100.0), filled(hall_of(6), 100.0, "harsh")
    assert len(all_on) == 6 * 4
    assert sorted({abs(float(light.position[1])) for light in harsh}) == [3.0, 9.0]
    assert sum(map(luminous_flux, harsh)) == pytest.approx(sum(map(luminous_flux, all_on)) / 9.0, rel=0.2)
    leaning = np.rad2deg([np.arctan2(light.direction[0], -light.direction[2]) for light in harsh])
    np.testing.assert_allclose(np.unique(leaning.round(6)), [-35.0, 35.0])


def test_the_rows_nearest_to_the_aisle_come_first() -> None:
    scene = replace(hall_of(3), aisle=(-20.0, 20.0, 3.0, 9.0))
    assert {float(light.position[1]) for light in filled(scene, 100.0, "harsh")} == {6.0}


def test_other_luminaires_fail_in_each_scene() -> None:
    one, other = (filled(hall_of(5), 100.0, "failing", seed) for seed in (0, 1))
    assert [light.intensity for light in one] != [light.intensity for light in other]
    assert [light.intensity for light in one] == [light.intensity for light in filled(hall_of(5), 100.0, "failing", 0)]


def test_rows_shine_as_the_photometric_file_of_the_luminaires_says() -> None:
    distribution = load_distribution(find_photometry("aisle_narrow"))
    preset = replace(PRESETS["nominal"], distribution=distribution)
    plain = filled(hall_of(4), 200.0)
    lights = fill_lights(hall_of(4), 200.0, [WHITE], preset, np.random.default_rng(0))
    assert [luminous_flux(light) for light in lights] == pytest.approx([luminous_flux(light) for light in plain])
    assert all(light.distribution is distribution and light.along == (1.0, 0.0, 0.0) for light in lights)
