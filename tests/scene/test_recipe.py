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
    ("loads: {cartons: [carton_1x1x1]}", "loads", "cartons: unknown catalog object 'carton_1x1x1'"),
    ("loads: {cartons: [epal1]}", "loads", "cartons must list catalog objects of class carton"),
    ("loads: {pallets: []}", "loads", "pallets must list"),
    ("loads: {height: {min: 1, max: 0.5}}", "loads: height", "min must not exceed max"),
    (
        "shelving: {yaw_deg: {mean: 0, std: 5}}",
        "shelving",
        r"yaw_deg must stay within -20 to 20 deg, found -inf; give it min and max",
    ),
    ("viewpoints: {kind: drone}", "viewpoints", "kind must be one of 'level', 'forklift_mast'"),
    ("viewpoints: {kind: free, trajectory: drive}", "viewpoints", "a free camera does not drive"),
    ("viewpoints: {kind: level, pitch_deg: -5}", "viewpoints", "a level camera has no pitch"),
    ("viewpoints: {kind: amr, level: true, pitch_deg: -5}", "viewpoints", "a level camera has no pitch"),
    ("viewpoints: {kind: level, roll_deg: 2}", "viewpoints", "a level camera has no roll"),
    ("viewpoints: {kind: post, level: true, roll_deg: {min: -1, max: 1}}", "viewpoints", "a level camera has no roll"),
    (
        "viewpoints: {kind: ceiling, level: true}",
        "viewpoints",
        "a ceiling camera neither looks along the horizon nor drives",
    ),
    (
        "viewpoints: {kind: ceiling, trajectory: drive}",
        "viewpoints",
        "a ceiling camera neither looks along the horizon nor drives",
    ),
    ("viewpoints: {drive: {start: 1.6, stop: 2}}", "viewpoints", "stop must stay below start, found 2.0 and 1.6"),
    ("loads: {tote_fraction: 0.7, sack_fraction: 0.7}", "loads", "must not exceed 1 together"),
    ("loads: {patterns: []}", "loads", "at least one pattern"),
    ("loads: {patterns: [herringbone]}", "loads: patterns", "herringbone"),
    ("loads: {drums: [epal1]}", "loads", "drums must list catalog objects of class drum"),
    ("loads: {sacks: [sack]}", "loads", "sacks"),
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
