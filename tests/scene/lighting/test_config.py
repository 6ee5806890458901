from pathlib import Path
from typing import get_args

import pytest
import yaml

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene import Distribution, SceneRecipe
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.exposure import ExposureConfig
from warehouse_sim.scene.lighting.presets import PRESETS, PresetName


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
        ("luminaires: 9", "luminaires must be 1-8, found 9"),
        ("rows: 0", "rows must be 1-3, found 0"),
        ("mounting_height: 14", "mounting_height must be 2.4-13.8 m, found 14"),
        ("{lux: 200, flux: 9000}", "lux and flux cannot both be given"),
        ("lux: {min: 0, max: 5}", "lux must stay within 0.001-200,000 lx, found 0"),
        ("flux: -5", "flux must stay within 1-10,000,000 lm"),
        ("beam_deg: 180", "beam_deg must be 10-150 deg, found 180"),
        ("ambient_fraction: -1", "ambient_fraction must be 0-10"),
        ("temperature: 500", "1,700-20,000 K"),
        ("white_balance: 90000", "1,700-20,000 K"),
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
