from functools import partial
from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene import Distribution, SceneRecipe, scene_rng
from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.random_settings import Choice, find_random_settings, with_values

TABLE = [
    (3, Distribution.constant(3.0)),
    ({"min": -1, "max": 2.5}, Distribution.uniform(-1.0, 2.5)),
    ({"choices": [1, 4]}, Distribution.choice(1.0, 4.0)),
    ({"choices": [1, 4], "weights": [3, 1]}, Distribution("choices", 1.0, 4.0, values=(1.0, 4.0), weights=(3.0, 1.0))),
    ({"mean": 1, "std": 0.5}, Distribution.normal(1.0, 0.5)),
    ({"mean": 1, "std": 0.5, "min": 0, "max": 3}, Distribution.normal(1.0, 0.5, 0.0, 3.0)),
]


@pytest.mark.parametrize(("plain", "expected"), TABLE)
def test_plain_data_reads_and_writes(plain: Any, expected: Distribution) -> None:
    assert Distribution.from_plain(plain, "here") == expected
    assert Distribution.from_plain(expected.to_plain(), "here") == expected


@pytest.mark.parametrize(
    ("plain", "message"),
    [
        ("wide", "number"),
        (True, "number"),
        (float("nan"), "number"),
        ({"min": 1}, "min, max"),
        ({"min": 1, "max": 2, "mx": 3}, "min, max"),
        ({"min": 2, "max": 1}, "min must not exceed max"),
        ({"min": "a", "max": 1}, "finite numbers"),
        ({"mean": 0, "std": -1}, "std must be >= 0"),
        ({"mean": 9, "std": 1, "max": 3}, "must lie between"),
        ({"choices": []}, "at least one"),
        ({"choices": 3}, "finite numbers"),
        ({"choices": [1, 2], "weights": [1]}, "one number of 0-1,000,000 per choice"),
        ({"choices": [1, 2], "weights": [0, 0]}, "not all 0"),
    ],
)
def test_bad_data_is_one_line_that_names_the_place(plain: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        Distribution.from_plain(plain, "file.yaml: scene: height")
    assert str(caught.value).startswith("file.yaml: scene: height")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("plain", "distribution"), TABLE)
def test_draws_stay_within_the_limits(plain: Any, distribution: Distribution) -> None:
    rng = np.random.default_rng(0)
    draws = np.array([distribution.sample(rng) for _ in range(2000)])
    assert draws.min() >= distribution.low
    assert draws.max() <= distribution.high


def test_moments_of_the_families() -> None:
    rng = np.random.default_rng(1)
    bell = [Distribution.normal(2.0, 0.3).sample(rng) for _ in range(20000)]
    assert np.mean(bell) == pytest.approx(2.0, abs=0.01)
    assert np.std(bell) == pytest.approx(0.3, abs=0.01)
    # Cutting a bell at one sigma leaves a deviation of 0.5396 of it and piles nothing up at the ends.
    cut = np.array([Distribution.normal(0.0, 1.0, -1.0, 1.0).sample(rng) for _ in range(20000)])
    assert np.std(cut) == pytest.approx(0.5396, abs=0.01)
    assert np.mean(np.abs(cut) > 0.999) < 0.002
    weighted = Distribution("choices", 0.0, 1.0, values=(0.0, 1.0), weights=(3.0, 1.0))
    assert np.mean([weighted.sample(rng) for _ in range(20000)]) == pytest.approx(0.25, abs=0.01)


def test_counts_of_an_even_range_include_both_ends_as_often() -> None:
    rng = np.random.default_rng(2)
    counts = np.bincount([Distribution.uniform(2, 5).sample_count(rng) for _ in range(8000)], minlength=6)
    assert counts[:2].sum() == 0
    np.testing.assert_allclose(counts[2:] / 8000, 0.25, atol=0.02)


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
