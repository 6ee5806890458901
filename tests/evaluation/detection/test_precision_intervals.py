"""Intervals of average precision against a closed form."""

import numpy as np
import pytest

from warehouse_sim.evaluation.detection.scores import Seen, precision_intervals


def part(scene: int, good: bool) -> Seen:
    """Return an image with one true object and one detection of it, right or wrong."""
    return Seen(scene, np.array([0.9 if good else 0.5]), np.array([True]), np.array([[0.8 if good else 0.1]]))


def test_scenes_are_drawn_whole() -> None:
    """Of four scenes of equal images one is always wrong: a fraction of (0..4) / 4 of those drawn, binomially."""
    parts = [part(scene, scene != 3) for scene in range(4) for _ in range(5)]
    value, low, high = precision_intervals(parts, 4000, np.random.default_rng(0))["box_50"]
    # Wrong ones have lower scores: precision is 1 up to the fraction of right ones, and is read at 0, 0.01, ... 1.
    assert value == pytest.approx(76 / 101, abs=1e-9)
    draws = np.random.default_rng(1).binomial(4, 0.75, 200_000) / 4
    expected = np.percentile(np.where(draws > 0, np.floor(draws * 100) + 1, 0) / 101, [2.5, 97.5])
    assert (low, high) == pytest.approx(tuple(expected), abs=1e-6)


def test_equal_scenes_have_no_width() -> None:
    for metric, (value, low, high) in precision_intervals(
        [part(scene, True) for scene in range(3)], 50, np.random.default_rng(0)
    ).items():
        assert metric in ("box_50", "box_75")
        assert value == low == high == 1.0
