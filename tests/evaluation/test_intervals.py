import numpy as np
import pytest

from warehouse_sim.evaluation.intervals import (
    difference_interval,
    fraction_interval,
    fraction_intervals,
    wilson,
)


def test_wilson_equals_the_published_example():
    # Newcombe, Statistics in Medicine 17 (1998), table I, method 3: 81 of 263 and 0 of 20.
    assert wilson(81 / 263, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0.0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_bootstrap_of_scenes_is_wider_when_scenes_are_alike_inside():
    scenes = np.repeat(np.arange(20), 30)
    alike = np.repeat(np.arange(20) % 2, 30).astype(float)
    mixed = np.tile([0.0, 1.0], 300)
    low, high = fraction_interval(alike, scenes, 1000, np.random.default_rng(0))
    assert high - low == pytest.approx(2 * 1.96 * np.sqrt(0.25 / 20), rel=0.1)
    narrow = fraction_interval(mixed, scenes, 1000, np.random.default_rng(0))
    assert narrow == wilson(0.5, 600), "every scene has the same mean: the bootstrap adds no width"


def test_share_interval_has_width_even_where_the_bootstrap_has_none():
    scenes = np.repeat(np.arange(4), 10)
    low, high = fraction_interval(np.ones(40), scenes, 200, np.random.default_rng(0))
    assert (low, high) == (wilson(1.0, 40)[0], 1.0)
    assert fraction_interval(np.ones(1), np.zeros(1, int), 200, np.random.default_rng(0))[0] < 0.3


def test_columns_of_one_table_have_the_intervals_that_each_has_alone():
    rng = np.random.default_rng(3)
    scenes = rng.integers(0, 9, 80)
    some = np.where(scenes < 5, rng.random(80), np.nan)
    columns = {"all": rng.random(80), "some": some, "scattered": np.where(rng.random(80) < 0.5, 1.0, np.nan)}
    found = fraction_intervals(columns | {"none": np.full(80, np.nan)}, scenes, 200, 5)
    assert set(found) == set(columns)
    for name, values in columns.items():
        known = ~np.isnan(values)
        assert found[name] == fraction_interval(values[known], scenes[known], 200, np.random.default_rng(5))


def test_one_scene_tells_nothing_of_differences() -> None:
    assert difference_interval(np.array([0.0, -1.0, 0.0]), np.zeros(3, dtype=int)) == (-1.0, 1.0)


def test_where_nothing_changed_the_interval_of_differences_is_as_wide_as_wilsons() -> None:
    low, high = difference_interval(np.zeros(40), np.arange(40) // 10)
    assert (-low, high) == pytest.approx((wilson(0.0, 40)[1],) * 2)


def test_with_scenes_of_one_pair_the_interval_of_differences_is_students() -> None:
    values = np.array([1.0, 0.0, 0.0, -1.0, 1.0, 1.0])
    half = 2.5705818 * values.std(ddof=1) / np.sqrt(6)  # the quantile of 5 degrees of freedom, from a table
    assert difference_interval(values, np.arange(6)) == pytest.approx(
        (max(values.mean() - half, -1.0), min(values.mean() + half, 1.0))
    )


def test_the_interval_of_differences_holds_the_true_mean_about_as_often_as_it_says() -> None:
    rng, held = np.random.default_rng(3), []
    for _ in range(400):
        scenes = rng.normal(0.1, 0.2, 8)  # pairs of a scene are alike
        values = np.clip(np.repeat(scenes, 12) + rng.normal(0.0, 0.2, 96), -1.0, 1.0)
        low, high = difference_interval(values, np.repeat(np.arange(8), 12))
        held.append(low <= 0.1 <= high)
    assert 0.91 <= np.mean(held) <= 0.99
