"""Rows of light beside the aisle give the hall's floor what is requested."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.building.to_size import light_line
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.resources import find_photometry
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.lighting.config import PRESETS, PresetName
from warehouse_sim.scene.lighting.hall_light import fill_lights
from warehouse_sim.scene.lighting.ies_file import load_distribution
from warehouse_sim.scene.lighting.photometry import luminous_flux, unshadowed_illuminance
from warehouse_sim.schema import Light, SceneSpec

WHITE = (1.0, 1.0, 1.0)


def hall(rows: int, length: float = 46.0) -> SceneSpec:
    draft = SceneDraft()
    for y in (np.arange(rows) - (rows - 1) / 2) * 6.0:
        draft.add(light_line(length), make_transform(translation=np.array([0.0, y, 7.5])))
    return SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), ())


def filled(scene: SceneSpec, lux: float, preset: PresetName = "nominal", seed: int = 0) -> tuple[Light, ...]:
    return fill_lights(scene, lux, [WHITE], PRESETS[preset], np.random.default_rng(seed))


@pytest.mark.parametrize("rows", [4, 7])
def test_the_floor_under_the_rows_gets_the_lux_over_what_is_lost_on_the_way(rows: int) -> None:
    lights = filled(hall(rows), 200.0)
    x, y = np.meshgrid(np.linspace(-15, 15, 31), np.linspace(-1, 1, 5) * 3.0 * (rows - 2))
    floor = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    lux = unshadowed_illuminance(lights, floor, np.tile([0.0, 0.0, 1.0], (len(floor), 1)))
    # Without walls and goods nothing is lost but what falls beyond the rows: between the wanted lux and that over 0.6.
    assert 200.0 < lux.mean() < 200.0 / 0.6 * 1.05
    assert lux.min() > 0.7 * lux.mean()


def test_they_are_few_and_all_fill() -> None:
    lights = filled(hall(9), 100.0)
    assert 9 <= len(lights) <= 30
    assert all(light.fill and light.direction[2] == -1.0 for light in lights)


def test_a_hall_without_rows_or_with_dark_ones_has_none() -> None:
    assert filled(hall(0), 200.0) == ()
    assert filled(hall(3), 0.0) == ()


def test_rows_take_the_colours_of_the_luminaires_in_turn() -> None:
    warm = (1.3, 0.9, 0.5)
    lights = fill_lights(hall(4), 100.0, [WHITE, warm], PRESETS["mixed_colour"], np.random.default_rng(0))
    by_row = {round(float(light.position[1]), 2): light.color for light in lights}
    assert [by_row[y] for y in sorted(by_row, key=abs)] == [WHITE, warm, WHITE, warm]


def test_rows_and_what_hangs_in_them_are_dark_in_the_pattern_of_the_preset() -> None:
    """Of every third luminaire of every third row comes a ninth of the light, in beams that lean both ways."""
    all_on, harsh = filled(hall(6), 100.0), filled(hall(6), 100.0, "harsh")
    assert len(all_on) == 6 * 4
    assert sorted({abs(float(light.position[1])) for light in harsh}) == [3.0, 9.0]
    assert sum(map(luminous_flux, harsh)) == pytest.approx(sum(map(luminous_flux, all_on)) / 9.0, rel=0.2)
    leaning = np.rad2deg([np.arctan2(light.direction[0], -light.direction[2]) for light in harsh])
    np.testing.assert_allclose(np.unique(leaning.round(6)), [-35.0, 35.0])


def test_the_rows_nearest_to_the_aisle_come_first() -> None:
    scene = replace(hall(3), aisle=(-20.0, 20.0, 3.0, 9.0))
    assert {float(light.position[1]) for light in filled(scene, 100.0, "harsh")} == {6.0}


def test_other_luminaires_fail_in_each_scene() -> None:
    one, other = (filled(hall(5), 100.0, "failing", seed) for seed in (0, 1))
    assert [light.intensity for light in one] != [light.intensity for light in other]
    assert [light.intensity for light in one] == [light.intensity for light in filled(hall(5), 100.0, "failing", 0)]


def test_rows_shine_as_the_photometric_file_of_the_luminaires_says() -> None:
    distribution = load_distribution(find_photometry("aisle_narrow"))
    preset = replace(PRESETS["nominal"], distribution=distribution)
    plain = filled(hall(4), 200.0)
    lights = fill_lights(hall(4), 200.0, [WHITE], preset, np.random.default_rng(0))
    assert [luminous_flux(light) for light in lights] == pytest.approx([luminous_flux(light) for light in plain])
    assert all(light.distribution is distribution and light.along == (1.0, 0.0, 0.0) for light in lights)
