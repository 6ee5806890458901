"""Intervals of the study over trainings with other seeds."""

import numpy as np
import pytest
from scipy.stats import ttest_1samp

from benchmarks.estimators.study import seed_interval


def test_the_interval_over_seeds_is_that_of_the_t_test():
    for values in ([0.1, 0.2, 0.4], [0.0, 0.01, -0.02, 0.03], [0.5, 0.5001]):
        expected = ttest_1samp(values, 0.0).confidence_interval(0.95)
        assert seed_interval(values) == pytest.approx((expected.low, expected.high), rel=1e-9)


def test_it_holds_the_true_mean_in_95_of_100_draws_of_three():
    draws = np.random.default_rng(0).normal(0.3, 0.02, (4000, 3))
    holds = [low <= 0.3 <= high for low, high in map(seed_interval, draws)]
    assert np.mean(holds) == pytest.approx(0.95, abs=0.015)


def test_one_seed_tells_nothing():
    assert seed_interval([0.07]) == (-1.0, 1.0)
