from functools import partial
from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene import Distribution, SceneRecipe, scene_rng
from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.random_settings import Choice, find_random_settings, with_values

PLAIN: dict[str, Any] = {
    "layout": {
        "kind": "rack_aisle",
        "bays": {"min": 2, "max": 4},
        "beam_levels": [{"min": 1.4, "max": 1.6}, 3.0],
        "signs": {"choices": [True, False]},
        "sides": {"choices": ["one", "both"], "weights": [1, 3]},
    },
    "loads": {"empty_fraction": {"mean": 0.3, "std": 0.1, "min": 0.0, "max": 1.0}, "height": {"min": 0.4, "max": 0.9}},
    "shelving": {"empty_slot_fraction": {"choices": [0.2, 0.6], "weights": [3, 1]}},
}


def test_what_is_open_is_found_and_distributions_are_left_alone() -> None:
    found = find_random_settings(SceneRecipe, PLAIN, "here")
    assert [(setting.path, setting.kind) for setting in found] == [
        (("layout", "bays"), "int"),
        (("layout", "beam_levels", 0), "float"),
        (("layout", "sides"), "name"),
        (("layout", "signs"), "name"),
        (("loads", "empty_fraction"), "float"),
        (("shelving", "empty_slot_fraction"), "float"),
    ]
    assert found[2].source == Choice(("one", "both"), (1.0, 3.0))


def test_a_recipe_draws_each_open_setting_again_and_reads_back() -> None:
    recipe = SceneRecipe.from_plain(PLAIN, "here")
    assert SceneRecipe.from_plain(recipe.to_plain(), "here") == recipe
    assert recipe.to_plain()["layout"]["bays"] == {"min": 2.0, "max": 4.0}
    sampled = [recipe.sampled(partial(scene_rng, 0, index)) for index in range(300)]
    assert {item.layout.to_plain()["bays"] for item in sampled} == {2, 3, 4}
    levels = np.array([item.layout.to_plain()["beam_levels"] for item in sampled])
    assert levels[:, 0].min() >= 1.4
    assert levels[:, 0].std() > 0.04
    np.testing.assert_array_equal(levels[:, 1], 3.0)
    assert np.mean([item.layout.to_plain()["sides"] == "both" for item in sampled]) == pytest.approx(0.75, abs=0.08)
    assert np.mean([item.shelving.empty_slot_fraction == 0.2 for item in sampled]) == pytest.approx(0.75, abs=0.08)
    assert all(item.loads.height == Distribution.uniform(0.4, 0.9) for item in sampled)
    assert all(item.random_settings == () for item in sampled)


def test_a_closed_recipe_draws_itself() -> None:
    recipe = SceneRecipe(layout=BlockStorageConfig())
    assert recipe.sampled(partial(scene_rng, 0, 0)) is recipe


def test_a_setting_that_is_opened_changes_no_other() -> None:
    more = PLAIN | {"lights": {"mounting_height": {"min": 6.0, "max": 8.0}}}
    few, many = (SceneRecipe.from_plain(plain, "here").sampled(partial(scene_rng, 0, 0)) for plain in (PLAIN, more))
    assert (few.layout, few.loads, few.shelving) == (many.layout, many.loads, many.shelving)
    assert few.lights != many.lights


@pytest.mark.parametrize(
    ("plain", "message"),
    [
        ({"layout": {"bays": {"min": 2, "max": 40}}}, "bays must stay within 1-12, found 40"),
        ({"layout": {"bays": {"mn": 2, "max": 4}}}, "here: layout: bays must be a number"),
        ({"layout": {"sides": {"choices": []}}}, "here: layout: sides must be a value or"),
        ({"layout": {"sides": {"choices": ["one", "left"]}}}, "sides must be one of 'one', 'both', found 'left'"),
        ({"observations_per_scene": {"min": 2, "max": 4}}, "observations_per_scene cannot be left open"),
        ({"random_settings": []}, "without random_settings"),
    ],
)
def test_bad_random_settings_are_found_on_reading(plain: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        SceneRecipe.from_plain(plain, "here")


def test_values_that_do_not_go_together_are_an_error_of_the_draw() -> None:
    plain = {"layout": {"beam_levels": [{"min": 1.0, "max": 3.0}, {"min": 2.0, "max": 4.0}]}}
    recipe = SceneRecipe.from_plain(plain, "here")
    with pytest.raises(ConfigError, match="a draw of the recipe: layout: beam_levels must rise"):
        _ = [recipe.sampled(partial(scene_rng, 0, index)) for index in range(100)]


def test_closing_leaves_the_original_alone() -> None:
    sampled = with_values(PLAIN, [(("layout", "beam_levels", 0), 1.5)])
    assert sampled["layout"]["beam_levels"] == [1.5, 3.0]
    assert PLAIN["layout"]["beam_levels"][0] == {"min": 1.4, "max": 1.6}
    assert from_mapping(SceneRecipe, {"layout": {"bays": 3}}, "here").random_settings == ()
