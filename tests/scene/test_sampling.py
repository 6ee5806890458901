from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.errors import PlacementError, RecipeError
from warehouse_sim.generation.recipe import load_recipe
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
