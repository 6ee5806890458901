import numpy as np

from warehouse_sim.dataset.checks.depth import matches_reading


def test_readings_with_noise_and_holes_are_of_their_ground_truth_and_those_of_another_place_are_not() -> None:
    rng = np.random.default_rng(0)
    clean = rng.uniform(2.0, 8.0, (40, 60))
    read = np.where(rng.random(clean.shape) < 0.4, 0.0, clean * (1 + 0.05 * rng.standard_normal(clean.shape)))
    assert matches_reading(clean, read)
    assert not matches_reading(clean[:, ::-1], read)
    assert not matches_reading(2.0 * clean, read)
    assert not matches_reading(np.zeros_like(clean), read)
    assert not matches_reading(clean[:-1], read)


def test_a_few_readings_say_nothing() -> None:
    read = np.zeros((40, 60))
    read[0, :50] = 3.0
    assert matches_reading(np.full((40, 60), 9.0), read)
