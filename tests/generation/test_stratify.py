import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset, scene_features
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import prepare_scene


def recipe(stratify: list[str]) -> Recipe:
    plain = to_mapping(load_recipe("smoke"))
    plain["split"]["stratify"] = stratify
    return from_mapping(Recipe, plain, "smoke")


def test_features_are_the_means_that_were_requested_for_in_that_order() -> None:
    both = scene_features(recipe(["lux", "visible_fraction"]), 0, 1)
    assert both.shape == (2,)
    assert 0.0 < both[1] <= 1.0
    (distance,) = scene_features(recipe(["distance"]), 0, 1)
    places = [view.T_world_camera[:3, 3] for view in prepare_scene(recipe([]), 0, 1).scene.viewpoints]
    assert len(places) == 2
    assert 1.5 < distance < 12.0


def test_the_manifest_of_a_stratified_dataset_is_the_same_with_any_number_of_workers() -> None:
    requested = recipe(["distance", "lux"])
    alone, shared = (plan_dataset(requested, GenerateConfig(scenes=4, workers=workers)).manifest for workers in (1, 2))
    assert alone == shared
    assert sorted(index for found in alone.splits.values() for index in found) == [0, 1, 2, 3]
    assert alone.recipe["split"]["stratify"] == ["distance", "lux"]


def test_an_unknown_feature_is_rejected() -> None:
    with pytest.raises(Exception, match="must be one of 'visible_fraction', 'distance', 'lux'"):
        recipe(["colour"])
