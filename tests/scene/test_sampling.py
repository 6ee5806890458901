from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import PlacementError, RecipeError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.resources import data_folder, recipe_names
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene, sampling, scene_rng
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.photometry import floor_points, unshadowed_illuminance
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.schema import SceneSpec

SMALL = SceneRecipe(layout=RackAisleConfig(bays=2, beam_levels=(1.45,)), observations_per_scene=3)


def poses(scene: SceneSpec) -> bytes:
    return b"".join(item.T_world_object.tobytes() for item in scene.instances)


def views(scene: SceneSpec) -> bytes:
    return b"".join(view.T_world_camera.tobytes() for view in scene.viewpoints)


def test_the_same_key_gives_the_same_bytes_and_each_number_matters() -> None:
    scene = sample_scene(SMALL, 0, 1)
    again = sample_scene(SMALL, 0, 1)
    assert (poses(scene), views(scene), scene.exposure) == (poses(again), views(again), again.exposure)
    others = [sample_scene(SMALL, 1, 1), sample_scene(SMALL, 0, 2), sample_scene(SMALL, 0, 1, attempt=1)]
    assert len({poses(other) for other in [scene, *others]}) == 4


def test_a_draw_in_lighting_or_viewpoints_moves_no_pallet() -> None:
    scene = sample_scene(SMALL, 0, 0)
    dark = replace(SMALL, lights=LightingConfig(preset="dim"))
    far = replace(SMALL, viewpoints=ViewpointsConfig(distance=Distribution.constant(6.0)), observations_per_scene=5)
    assert poses(sample_scene(dark, 0, 0)) == poses(scene)
    assert views(sample_scene(dark, 0, 0)) == views(scene)
    assert poses(sample_scene(far, 0, 0)) == poses(scene)
    assert sample_scene(far, 0, 0).exposure == scene.exposure


def test_a_load_on_the_floor_moves_none_in_the_rack() -> None:
    without = sample_scene(replace(SMALL, staging=StagingConfig(count=Distribution.constant(0))), 0, 0)
    assert poses(sample_scene(SMALL, 0, 0)).startswith(poses(without))


def test_everything_visible_has_a_name() -> None:
    scene = sample_scene(SceneRecipe(), 0, 0)
    ids = [item.instance_id for item in scene.instances]
    assert ids == list(range(1, len(ids) + 1))
    classes = Counter(scene.model_of(item).class_name for item in scene.instances)
    assert set(classes) == {"floor", "wall", "door", "rack", "luminaire", "pallet", "carton"}
    assert {part.material for model in scene.models.values() for part in model.parts} == set(scene.materials)
    for item in scene.instances:
        assert item.dynamic == (scene.model_of(item).class_name in ("pallet", "carton")) == (item.group > 0)


def test_each_group_is_one_pallet_and_cartons_of_one_sku() -> None:
    scene = sample_scene(SceneRecipe(), 0, 3)
    groups: dict[int, list[str]] = {}
    for item in scene.instances:
        if item.group:
            groups.setdefault(item.group, []).append(item.model)
    assert 15 <= len(groups) <= 35
    for models in groups.values():
        assert [model.startswith("epal1") for model in models] == [True] + [False] * (len(models) - 1)
        assert len(set(models[1:])) <= 1
        assert len(models) <= 25


def test_the_default_scene_is_lit_like_a_warehouse() -> None:
    # EN 12464-1 requires 200 lx where people work in a store and 300 lx where they read labels.
    for index in range(2):
        scene = sample_scene(SceneRecipe(), 0, index)
        points = floor_points(scene)
        up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        floor = unshadowed_illuminance(scene.lights, points, up) + scene.ambient
        assert 200.0 <= np.mean(floor) <= 300.0
        assert min(floor) > 0.3 * np.mean(floor)


@pytest.mark.parametrize(
    ("recipe", "message"),
    [
        (replace(SMALL, staging=StagingConfig(count=Distribution.constant(40))), "lower staging.count"),
        (
            replace(SMALL, layout=RackAisleConfig(bays=1, aisle_width=3.0), staging=StagingConfig()),
            "lower staging.count or staging.depth",
        ),
        (
            replace(
                SMALL,
                loads=UnitLoadConfig(empty_fraction=0.0, cartons=("carton_600x400x400",)),
                layout=RackAisleConfig(beam_levels=(0.6, 1.2)),
            ),
            "none of carton_600x400x400 fits .* 0.23 m high",
        ),
        (
            replace(SMALL, shelving=ShelvingConfig(empty_slot_fraction=0.0), loads=UnitLoadConfig(pallets=("epal3",))),
            "lower shelving.yaw_deg",
        ),
        (replace(SMALL, viewpoints=ViewpointsConfig(distance=Distribution.constant(20.0))), "no viewpoint found"),
    ],
)
def test_what_does_not_fit_names_scene_and_seed_in_one_line(recipe: SceneRecipe, message: str) -> None:
    with pytest.raises(PlacementError, match=message) as caught:
        sample_scene(recipe, 7, 3)
    assert str(caught.value).startswith("scene 3 of seed 7, attempt 0: ")
    assert "\n" not in str(caught.value)


def test_random_settings_are_drawn_again_for_each_scene_and_repeat_with_the_key() -> None:
    plain = {"layout": {"bays": {"min": 1, "max": 4}}, "observations_per_scene": 1, "staging": {"count": 1}}
    recipe = SceneRecipe.from_plain(plain, "here")
    frames = [Counter(item.model for item in sample_scene(recipe, 0, index).instances) for index in range(6)]
    assert len({count["rack_frame_3500"] for count in frames}) > 1
    assert poses(sample_scene(recipe, 0, 3)) == poses(sample_scene(recipe, 0, 3))


def first(*key: object) -> float:
    return float(scene_rng(*key).random())  # type: ignore[arg-type]


def test_a_stream_depends_on_all_of_its_key_and_on_nothing_else() -> None:
    np.random.seed(3)  # noqa: NPY002  the global state must not matter
    draws = [
        first(0, 0, "loads"),
        first(1, 0, "loads"),
        first(0, 1, "loads"),
        first(0, 0, "lights"),
        first(0, 0, "loads", 1),
    ]
    assert len(set(draws)) == 5
    assert first(0, 0, "loads") == draws[0]
    assert first(0, 0, "loads", 0) == draws[0]


@pytest.mark.parametrize("key", [(-1, 0, "a"), (0, -1, "a"), (0, 0, "a", -1)])
def test_negative_numbers_are_rejected(key: tuple[object, ...]) -> None:
    with pytest.raises(RecipeError, match="must be >= 0, found -1"):
        first(*key)


def test_no_two_stages_of_a_scene_share_a_stream(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def recorded(seed: int, index: int, stage: str, *more: int) -> np.random.Generator:
        asked.append(stage)
        return scene_rng(seed, index, stage, *more)

    monkeypatch.setattr(sampling, "scene_rng", recorded)
    sampling.sample_scene(load_recipe("smoke").scene, 0, 0)
    assert "staging" in asked
    assert "lanes" in asked
    assert len(set(asked)) == len(asked)


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
