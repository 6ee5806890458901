from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import yaml

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene import Distribution, SceneRecipe
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig, PresetName
from warehouse_sim.scene.lighting.exposure import ExposureConfig, ev_of_exposure, exposure_of_ev, metered_ev
from warehouse_sim.scene.lighting.switching import relit


def read(text: str) -> LightingConfig:
    return from_mapping(LightingConfig, yaml.safe_load(text), "here")


def test_every_preset_has_a_name_and_reads_back() -> None:
    assert set(PRESETS) == set(get_args(PresetName))
    for name in PRESETS:
        config = read(f"preset: {name}")
        assert config.resolved() == PRESETS[name]
        assert from_mapping(LightingConfig, to_mapping(config), "here") == config


def test_what_a_recipe_says_replaces_what_the_preset_means() -> None:
    text = "{preset: dim, lux: 80, beam_deg: 60, temperature: 3000, exposure: {mode: fixed, ev: 6}, headlights: true}"
    preset = read(text).resolved()
    assert preset.lux == Distribution.constant(80.0)
    assert preset.temperatures == (Distribution.constant(3000.0),)
    assert (preset.beam_deg, preset.headlights) == (60.0, True)
    assert preset.exposure == ExposureConfig("fixed", ev=6.0)
    assert preset.pattern == PRESETS["dim"].pattern


def test_presets_and_stops_may_be_left_open() -> None:
    plain = {"lights": {"preset": {"choices": ["dim", "night"]}, "exposure": {"compensation": {"min": 0, "max": 1}}}}
    recipe = SceneRecipe.from_plain(plain, "here")
    assert [setting.name for setting in recipe.random_settings] == ["lights.exposure.compensation", "lights.preset"]
    assert SceneRecipe.from_plain(recipe.to_plain(), "here") == recipe


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("preset: gloomy", "preset must be one of 'nominal', 'dim'"),
        ("{lux: 200, flux: 9000}", "lux and flux cannot both be given"),
        ("intensity: 5000", "intensity is not a setting"),
        ("exposure: {mode: fixed}", "ev belongs to the fixed mode"),
    ],
)
def test_what_makes_no_light_is_rejected_by_name(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        read(text)


def test_compensation_comes_on_top_of_the_presets_and_both_stay_in_range() -> None:
    assert read("{preset: harsh, compensation: 0.75}").resolved().exposure.compensation == pytest.approx(0.25)
    assert read("preset: harsh").resolved() == PRESETS["harsh"]
    with pytest.raises(ConfigError, match="compensation must be"):
        read("{exposure: {compensation: 4}, compensation: 2}")


def test_photometry_is_read_with_the_recipe_and_rejected_with_file_and_line(tmp_path: Path) -> None:
    assert LightingConfig().resolved().distribution is None
    own = from_mapping(LightingConfig, {"photometry": "aisle_narrow"}, "recipe.yaml: lights").resolved()
    assert own.distribution is not None
    assert own.distribution.name == "aisle_narrow"
    with pytest.raises(ConfigError, match="aisle_narrow, highbay_wide"):
        from_mapping(LightingConfig, {"photometry": "aisle_narow"}, "recipe.yaml: lights")
    broken = tmp_path / "broken.ies"
    broken.write_text("IESNA:LM-63-2002\nTILT=NONE\n1 -1 x\n")
    with pytest.raises(ConfigError, match=r"recipe.yaml: lights: .*broken.ies: line 3: expected a number"):
        from_mapping(LightingConfig, {"photometry": str(broken)}, "recipe.yaml: lights")


@pytest.mark.parametrize(
    "settings",
    [
        {"photometry": "aisle_narrow", "beam_deg": 80.0},
        {"photometry_flux": True},
        {"photometry": "aisle_narrow", "photometry_flux": True, "lux": 100.0},
    ],
)
def test_photometry_stands_in_place_of_other_settings(settings: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="photometry"):
        from_mapping(LightingConfig, settings, "recipe.yaml: lights")


BEFORE = LightingConfig(rows=2, luminaires=5, mounting_height=6.0, lux=Distribution.constant(500.0), temperature=None)


def test_what_was_said_of_light_is_forgotten_and_luminaires_stay() -> None:
    after = relit(BEFORE, "night", {}, "here")
    assert (after.rows, after.luminaires, after.mounting_height) == (2, 5, 6.0)
    assert after.lux is None
    assert after.resolved() == PRESETS["night"]


def test_settings_of_light_are_taken() -> None:
    after = relit(BEFORE, "dim", {"lux": 12.0, "headlights": True}, "here")
    assert after.lux == Distribution.constant(12.0)
    assert after.headlights is True


@pytest.mark.parametrize("settings", [{"rows": 1}, {"luminaires": 2}, {"mounting_height": 5.0}, {"luminaire": "round"}])
def test_luminaires_are_not_moved(settings: dict) -> None:
    with pytest.raises(ConfigError, match=r"here: .*hang already"):
        relit(BEFORE, "dim", settings, "here")


EVEN = np.ones(3)


def test_exposure_values_are_those_of_photography() -> None:
    # 4000 cd/m^2, a sunlit scene, is EV 15 at ISO 100 by the usual tables and K = 12.5.
    assert metered_ev(np.full(3, 4096.0), EVEN) == pytest.approx(15.0)
    assert exposure_of_ev(15.0) == pytest.approx(1.0 / (1.2 * 2**15))
    assert exposure_of_ev(5.0) == pytest.approx(2 * exposure_of_ev(6.0))
    for ev in (-3.0, 0.0, 7.25):
        assert ev_of_exposure(exposure_of_ev(ev)) == pytest.approx(ev)


def test_the_meter_takes_the_weighted_mean_of_encoded_values() -> None:
    luminance, weights = np.array([0.0, 8.0]), np.array([3.0, 1.0])
    assert metered_ev(luminance, weights) == pytest.approx(np.log2(8 * 8.0) - 2 * 2.2)
    door = np.array([20.0] * 9 + [5000.0])
    log_average, average = (np.log2(8 * value) for value in (np.exp(np.log(door).mean()), door.mean()))
    assert log_average + 1 < metered_ev(door, np.ones(10)) < average - 1


def test_compensation_brightens_and_the_camera_has_a_limit() -> None:
    luminance = np.full(3, 1.0)  # EV 3
    assert ExposureConfig(compensation=1.0).ev_for(luminance, EVEN) == pytest.approx(2.0)
    assert ExposureConfig(min_ev=5.0).ev_for(luminance, EVEN) == 5.0
    assert ExposureConfig("fixed", ev=9.0).ev_for(luminance, EVEN) == 9.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"mode": "fixed"}, "ev belongs to the fixed mode"),
        ({"ev": 3.0}, "ev belongs to the fixed mode"),
    ],
)
def test_what_makes_no_exposure_is_rejected(settings: dict, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        ExposureConfig(**settings)


def test_a_view_without_light_is_metered_without_a_warning() -> None:
    assert np.isfinite(metered_ev(np.zeros(3), np.ones(3)))
