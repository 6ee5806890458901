from pathlib import Path

import pytest
import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.resources import data_folder, recipe_names
from warehouse_sim.scene import SceneRecipe

BAD = [
    ("layout: {bays: 0}", "layout", "bays must be 1-12, found 0"),
    ("layout: {bays: two}", "layout", "bays must be int"),
    ("layout: {baise: 2}", "layout", "baise is not a setting; did you mean 'bays'"),
    ("layout: {sides: left}", "layout", "sides must be one of 'one', 'both'"),
    ("layout: {beam_levels: [2.0, 2.1]}", "layout", "beam_levels must rise"),
    ("layout: {beam_levels: [], ground_level: false}", "layout", "no slot is left"),
    ("layout: {aisle_width: -3}", "layout", "aisle_width must be 1.5-15 m, found -3.0"),
    ("loads: {empty_fraction: 1.5}", "loads", "empty_fraction must be 0-1, found 1.5"),
    ("loads: {cartons: [carton_1x1x1]}", "loads", "cartons: unknown catalog object 'carton_1x1x1'"),
    ("loads: {cartons: [epal1]}", "loads", "cartons must list catalog objects of class carton"),
    ("loads: {pallets: []}", "loads", "pallets must list"),
    ("loads: {max_cartons: 0}", "loads", "max_cartons must be 1-1,000, found 0"),
    ("loads: {height: {min: 1, max: 0.5}}", "loads: height", "min must not exceed max"),
    ("loads: {stacking: {gap_mm: 0}}", "loads: stacking", "gap_mm must be 1-30"),
    ("loads: {stacking: {top_layer_fraction: 2}}", "loads: stacking", "top_layer_fraction must stay within 0-1"),
    (
        "shelving: {yaw_deg: {mean: 0, std: 5}}",
        "shelving",
        r"yaw_deg must stay within -20 to 20 deg, found -inf; give it min and max",
    ),
    ("shelving: {empty_slot_fraction: -0.1}", "shelving", "empty_slot_fraction must be 0-1, found -0.1"),
    ("staging: {count: -1}", "staging", "count must stay within 0-40"),
    ("staging: {depth: 0.5}", "staging", "depth must stay within 0.8-30 m, found 0.5"),
    ("lights: {luminaires: 9}", "lights", "luminaires must be 1-8, found 9"),
    ("lights: {lux: 0}", "lights", "lux must stay within 0.001-200,000 lx, found 0"),
    ("lights: {temperature: 500}", "lights", "1,700-20,000 K"),
    ("viewpoints: {distance: {min: 0, max: 4}}", "viewpoints", "distance must stay within 1-50 m"),
    ("viewpoints: {height: 0}", "viewpoints", "height must stay within 0.1-20 m"),
    ("viewpoints: {aisle_fraction: 2}", "viewpoints", "aisle_fraction must be 0-1, found 2.0"),
    ("viewpoints: {max_elevation_deg: 80}", "viewpoints", "max_elevation_deg must be 1-45"),
    ("observations_per_scene: 0", "", "observations_per_scene must be 1-1,000, found 0"),
    ("targets: [wall]", "", "targets must list"),
    ("lihgts: {}", "", "lihgts is not a setting; did you mean 'lights'"),
]


@pytest.mark.parametrize(("text", "key", "message"), BAD)
def test_a_bad_recipe_is_one_line_naming_file_and_key(text: str, key: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(RecipeError, match=message) as caught:
        load_yaml(SceneRecipe, path, RecipeError)
    assert str(caught.value).startswith(f"{path}: {key}")
    assert "\n" not in str(caught.value)


def test_a_resolved_recipe_reads_back_equal(tmp_path: Path) -> None:
    path = tmp_path / "resolved.yaml"
    path.write_text(yaml.safe_dump(to_mapping(SceneRecipe())))
    assert load_yaml(SceneRecipe, path, RecipeError) == SceneRecipe()


@pytest.mark.parametrize("name", recipe_names())
def test_shipped_recipes_are_read_and_read_back(name: str) -> None:
    recipe = load_recipe(name).scene
    assert SceneRecipe.from_plain(to_mapping(recipe), name) == recipe
    assert "pallet" in recipe.targets


def test_the_industrial_set_is_816_observations() -> None:
    whole = yaml.safe_load((data_folder("scenes") / "industrial.yaml").read_text())
    assert whole["scenes"] * whole["scene"]["observations_per_scene"] == 816
