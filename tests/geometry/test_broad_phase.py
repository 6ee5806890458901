import numpy as np
import pytest

from warehouse_sim.geometry.separation import overlapping_pairs


def all_pairs(low_a: np.ndarray, high_a: np.ndarray, low_b: np.ndarray, high_b: np.ndarray) -> np.ndarray:
    near = (low_a[:, None] <= high_b[None]).all(axis=2) & (low_b[None] <= high_a[:, None]).all(axis=2)
    return np.argwhere(near)


@pytest.mark.parametrize("seed", range(6))
def test_the_sweep_finds_what_comparing_all_pairs_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low_a, low_b = (np.round(rng.uniform(0, 6, (count, 3)), 1) for count in (70, 90))  # rounded: many ties
    high_a, high_b = (low + np.round(rng.uniform(0, 2.0, low.shape), 1) for low in (low_a, low_b))
    low_a[0], high_a[0] = 0.0, [40.0, 40.0, 0.1]  # a floor among cartons
    expected = all_pairs(low_a, high_a, low_b, high_b)
    assert len(expected) > 100
    np.testing.assert_array_equal(overlapping_pairs(low_a, high_a, low_b, high_b), expected)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("room", [(60.0, 3.0, 8.0), (30.0, 25.0, 9.0), (2.0, 2.0, 2.0)])
def test_strips_of_a_hall_lose_no_pair_and_name_none_twice(seed: int, room: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(seed)
    low_a, low_b = (np.round(rng.uniform(-1.0, 1.0, (count, 3)) * room, 1) for count in (300, 200))
    high_a, high_b = (low + np.round(rng.uniform(0, 1.2, low.shape), 1) for low in (low_a, low_b))
    low_a[:5], high_a[:5] = -np.array(room), np.array(room) * rng.uniform(-1.0, 1.0, (5, 3)).round(1)  # beams, floors
    high_b[:20] = low_b[:20]  # points
    expected = all_pairs(low_a, high_a, low_b, high_b)
    np.testing.assert_array_equal(overlapping_pairs(low_a, high_a, low_b, high_b), expected)


def test_boxes_that_touch_count_and_empty_sets_have_no_pairs() -> None:
    low, high = np.zeros((1, 3)), np.ones((1, 3))
    np.testing.assert_array_equal(overlapping_pairs(low, high, low + np.eye(3)[0], high + np.eye(3)[0]), [[0, 0]])
    assert overlapping_pairs(low, high, low + 1.001 * np.eye(3)[0], high + 1.001 * np.eye(3)[0]).shape == (0, 2)
    assert overlapping_pairs(low[:0], high[:0], low, high).shape == (0, 2)
