"""Panes of rooflights and windows send what they show into the hall."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.building.to_size import rooflight, window_band
from warehouse_sim.catalog.materials import materials
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig
from warehouse_sim.scene.lighting.daylight import PANE, pane_lights
from warehouse_sim.scene.lighting.photometry import luminous_flux
from warehouse_sim.scene.lighting.switching import sample_lighting
from warehouse_sim.schema import SceneSpec

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
