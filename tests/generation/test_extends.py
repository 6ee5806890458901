"""A recipe that extends another is the recipe that a copy with the same settings is."""

from pathlib import Path

import pytest
import yaml

from warehouse_sim.config import to_mapping
from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.extends import overlay
from warehouse_sim.resources import find_recipe
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.lighting.config import PRESETS

BASE = """
description: The base.
name: base
scene:
  layout: {kind: rack_aisle, bays: 3, beam_levels: [1.5, 3.0]}
  shelving: {yaw_deg: {mean: 0, std: 2, min: -6, max: 6}}
  staging: {count: {min: 2, max: 6}}
sensors: {lidar: {model: vlp16, range_noise: 0.01}}
scenes: 7
"""


def recipe_file(folder: Path, text: str, name: str = "own.yaml") -> str:
    (folder / name).write_text(text)
    return str(folder / name)


@pytest.fixture
def base(tmp_path: Path) -> Path:
    (tmp_path / "base.yaml").write_text(BASE)
    return tmp_path


def test_an_extended_recipe_equals_a_copy_with_the_same_settings(tmp_path: Path) -> None:
    extended = recipe_file(tmp_path, "extends: industrial\nscene: {targets: [pallet, carton]}\nscenes: 25")
    copy = yaml.safe_load(find_recipe("industrial").read_text())
    copy["scene"]["targets"], copy["scenes"] = ["pallet", "carton"], 25
    (tmp_path / "copy").mkdir()
    copied = recipe_file(tmp_path / "copy", yaml.safe_dump(copy))
    assert load_recipe(extended) == load_recipe(copied)
    assert to_mapping(load_recipe(extended)) == to_mapping(load_recipe(copied))


def test_mappings_are_merged_and_lists_and_distributions_replaced(base: Path) -> None:
    text = """
    extends: base.yaml
    scene:
      layout: {beam_levels: [1.8]}
      shelving: {yaw_deg: {min: -3, max: 3}}
      staging: {count: 4}
    sensors: {lidar: {motion: raw}}
    """
    recipe = load_recipe(recipe_file(base, text))
    assert (recipe.description, recipe.name, recipe.scenes) == ("The base.", "own", 7)
    plain = to_mapping(recipe.scene)
    assert (plain["layout"]["bays"], plain["layout"]["beam_levels"]) == (3, [1.8])
    assert plain["shelving"]["yaw_deg"] == {"min": -3.0, "max": 3.0}
    assert recipe.scene.staging.count.low == recipe.scene.staging.count.high == 4
    assert recipe.sensors.lidar is not None
    assert (recipe.sensors.lidar.range_noise, recipe.sensors.lidar.motion) == (0.01, "raw")


def test_a_mapping_of_another_kind_takes_nothing_over() -> None:
    rack = {"layout": {"kind": "rack_aisle", "bays": 3}, "lidar": {"model": "vlp16", "range_noise": 0.01}}
    assert overlay(rack, {"layout": {"kind": "mixed"}})["layout"] == {"kind": "mixed"}
    assert overlay(rack, {"layout": {"kind": "rack_aisle"}})["layout"] == rack["layout"]
    assert overlay(rack, {"lidar": {"model": "os1_128"}})["lidar"] == {"model": "os1_128"}
    assert overlay(rack, {"lidar": "os1_128"})["lidar"] == "os1_128"
    assert overlay(rack, {"lidar": None})["lidar"] is None
    assert overlay({"sensors": {"camera": "kitti"}}, {"sensors": {"rig": "amr"}})["sensors"] == {"rig": "amr"}
    assert overlay({"rgbd": {"depth": {"preset": "d435", "near": 0.2}}}, {"rgbd": {"depth": {"preset": "d455"}}}) == {
        "rgbd": {"depth": {"preset": "d455"}}
    }
    assert rack["layout"] == {"kind": "rack_aisle", "bays": 3}  # untouched


def test_a_recipe_that_extends_another_can_be_extended(base: Path) -> None:
    recipe_file(base, "extends: base.yaml\nscenes: 8\nscene: {observations_per_scene: 3}", "middle.yaml")
    recipe = load_recipe(recipe_file(base, "extends: middle.yaml\nscenes: 9"))
    assert (recipe.scenes, recipe.scene.observations_per_scene, recipe.name) == (9, 3, "own")


def test_an_own_recipe_may_bear_the_name_of_the_shipped_one_that_it_extends(tmp_path: Path) -> None:
    recipe = load_recipe(recipe_file(tmp_path, "extends: smoke\nscenes: 5", "smoke.yaml"))
    assert (recipe.name, recipe.scenes) == ("smoke", 5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("extends: nowhere", "own.yaml: extends: unknown recipe .* 'nowhere'; known: .*industrial"),
        ("extends: nowhere.yaml", "own.yaml: extends: unknown recipe .*nowhere.yaml"),
        ("extends: [base]", r"own.yaml: extends must be a shipped recipe's name or the path .* found \['base'\]"),
        ("extends: own.yaml", "own.yaml: extends leads back to where it began: .*own.yaml -> .*own.yaml"),
        (
            "extends: base.yaml\nscene: {layout: {baise: 2}}",
            "own.yaml: scene: layout: baise is not a setting",
        ),
        ("extends: base.yaml\nscenes: 0", "own.yaml: scenes must be 1-1,000,000, found 0"),
        ("extends: base.yaml\nscene: 3", "own.yaml: scene: expected a mapping"),
        ("- extends", "own.yaml: expected a mapping of settings"),
    ],
)
def test_a_bad_extension_is_one_line_naming_file_and_key(text: str, message: str, base: Path) -> None:
    with pytest.raises(RecipeError, match=message) as caught:
        load_recipe(recipe_file(base, text))
    assert "\n" not in str(caught.value)


def test_what_is_wrong_in_the_base_is_said_of_the_base(base: Path) -> None:
    recipe_file(base, BASE.replace("bays: 3", "bays: 0"), "base.yaml")
    own = recipe_file(base, "extends: base.yaml\nscene: {layout: {bays: 4}}")
    with pytest.raises(RecipeError, match=r"base.yaml: scene: layout: bays must be 1-12, found 0"):
        load_recipe(own)


def test_a_longer_circle_is_rejected(base: Path) -> None:
    recipe_file(base, "extends: own.yaml", "other.yaml")
    with pytest.raises(RecipeError, match=r"other.yaml: extends leads back"):
        load_recipe(recipe_file(base, "extends: other.yaml"))


@pytest.mark.parametrize(
    ("name", "base_name", "scenes", "targets", "kept"),
    [
        ("industrial_cartons", "industrial", 25, ("pallet", "carton"), ()),
        ("mixed_cartons", "mixed_pallets", 25, ("pallet", "carton"), ("viewpoints", "carton_wear", "loads.prints")),
        ("industrial_more", "industrial", 100, ("pallet",), ()),
        ("mixed_more", "mixed_pallets", 110, ("pallet",), ("viewpoints",)),
    ],
)
def test_the_training_sets_differ_from_their_base_in_size_split_and_targets(
    name: str, base_name: str, scenes: int, targets: tuple[str, ...], kept: tuple[str, ...]
) -> None:
    # What is kept is what the bundled estimators have learnt: level cameras, cartons of one geometry an SKU.
    recipe, base_recipe = load_recipe(name), load_recipe(base_name)
    assert (recipe.scenes, recipe.scene.targets, recipe.split.test) == (scenes, targets, 0.0)
    plain, base_plain = to_mapping(recipe), to_mapping(base_recipe)
    plain["scene"]["targets"] = base_plain["scene"]["targets"]
    for key in ("description", "name", "scenes", "split"):
        plain[key] = base_plain[key]
    # So is the camera of mixed_more and mixed_cartons, whose base has a warehouse's own since.
    assert load_recipe("industrial").sensors == recipe.sensors
    plain["sensors"] = base_plain["sensors"]
    for key in kept:
        *path, last = key.split(".")
        own, other = plain["scene"], base_plain["scene"]
        for step in path:
            own, other = own[step], other[step]
        assert own[last] != other[last]
        own[last] = other[last]
    assert plain == base_plain


def test_a_dataset_of_an_extended_recipe_is_described_as_a_copys(tmp_path: Path) -> None:
    settings = "scene: {targets: [pallet, carton], observations_per_scene: 1}\n"
    copy = yaml.safe_load(find_recipe("smoke").read_text())
    copy["scene"] |= {"targets": ["pallet", "carton"], "observations_per_scene": 1}
    found = []
    for folder, text in (("extended", f"extends: smoke\n{settings}"), ("copy", yaml.safe_dump(copy))):
        (tmp_path / folder).mkdir()
        recipe = load_recipe(recipe_file(tmp_path / folder, text))
        found.append((recipe, plan_dataset(recipe, GenerateConfig(scenes=1)).manifest))
    assert found[0] == found[1]


def test_a_light_preset_replaces_what_the_extended_recipe_says_of_light(tmp_path: Path) -> None:
    """The demo requires 180-320 lx; night has its own 0.5-2 lx, and luminaires stay where they hang."""
    path = tmp_path / "dark.yaml"
    path.write_text("extends: demo\nscene: {lights: {preset: night}}\n")
    lights, demo = load_recipe(str(path)).scene.lights, load_recipe("demo").scene.lights
    assert lights.resolved() == PRESETS["night"]
    assert (lights.luminaires, lights.mounting_height) == (demo.luminaires, demo.mounting_height)
    path.write_text("extends: demo\nscene: {lights: {preset: night, lux: 5}}\n")
    assert load_recipe(str(path)).scene.lights.resolved().lux == Distribution.constant(5.0)
    path.write_text("extends: demo\nscene: {lights: {luminaires: 5}}\n")
    assert load_recipe(str(path)).scene.lights.lux == demo.lux
