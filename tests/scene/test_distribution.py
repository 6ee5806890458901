from typing import Any

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.scene import Distribution

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
