"""Ranking and rejecting, against counts by hand and against a plain double loop."""

import numpy as np
import pytest

from tests.evaluation.tables import missed, row, table, without_pockets
from warehouse_sim.evaluation.trust import (
    Trust,
    auroc,
    auroc_interval,
    bound_coverage,
    least_area,
    risk_coverage,
    succeeded,
    trust_of,
)


def test_auroc_is_the_share_of_pairs_in_order_ties_counting_half():
    rng = np.random.default_rng(3)
    score = rng.integers(0, 6, 80) / 5.0
    right = rng.random(80) < 0.3 + 0.4 * score
    pairs = [(a > b) + 0.5 * (a == b) for a in score[right] for b in score[~right]]
    assert auroc(score, right) == pytest.approx(np.mean(pairs), abs=1e-12)


def test_auroc_without_failures_is_not_known():
    assert np.isnan(auroc(np.array([0.2, 0.9]), np.array([True, True])))
    low, high = auroc_interval(
        np.array([0.2, 0.9]), np.array([True, True]), np.array([0, 1]), 50, np.random.default_rng(0)
    )
    assert np.isnan(low)
    assert np.isnan(high)


def test_the_interval_resamples_scenes_and_not_rows():
    rng = np.random.default_rng(1)
    score, right = rng.random(40), rng.random(40) < 0.5
    alone = auroc_interval(score, right, np.arange(40), 400, np.random.default_rng(0))
    # A thousand copies of each row in its scene are no new verification.
    many = auroc_interval(
        *(np.repeat(item, 20) for item in (score, right, np.arange(40))), 400, np.random.default_rng(0)
    )
    assert many == pytest.approx(alone)
    assert alone[0] < auroc(score, right) < alone[1]


def test_risk_coverage_by_hand():
    curve = risk_coverage(np.array([0.9, 0.8, 0.7, 0.6]), np.array([True, False, True, False]))
    assert curve.coverage.tolist() == [0.25, 0.5, 0.75, 1.0]
    assert curve.risk == pytest.approx([0.0, 1 / 2, 1 / 3, 1 / 2])
    assert curve.area == pytest.approx((0 + 1 / 2 + 1 / 3 + 1 / 2) / 4)
    assert curve.score.tolist() == [0.9, 0.8, 0.7, 0.6]


def test_ties_are_kept_or_rejected_together_in_any_order():
    score, right = np.array([0.5, 0.5, 0.5, 0.9]), np.array([False, True, True, True])
    for turn in range(4):
        curve = risk_coverage(np.roll(score, turn), np.roll(right, turn))
        assert curve.coverage.tolist() == [0.25, 1.0]
        assert curve.risk.tolist() == [0.0, 0.25]


def test_a_score_that_says_nothing_has_the_share_of_failures_for_area():
    right = np.arange(200) % 5 > 0
    assert risk_coverage(np.zeros(200), right).area == pytest.approx(0.2)


def test_a_perfect_ranking_has_the_least_area_and_its_limit():
    right = np.arange(20_000) % 4 > 0
    perfect = risk_coverage(np.arange(20_000) / 1e6 + right, right)
    assert least_area(right) == pytest.approx(perfect.area)
    # Geifman, Uziel and El-Yaniv 2019: r + (1 - r) ln(1 - r) for many estimates of which r fail.
    assert perfect.area == pytest.approx(0.25 + 0.75 * np.log(0.75), abs=1e-3)


def test_right_is_docking_where_there_are_pockets_and_the_diameter_elsewhere():
    fails = row(slack_lateral=-0.001)
    far = without_pockets() | {"add": 0.06 * 1.449}
    near = without_pockets() | {"add": 0.04 * 1.449}
    assert succeeded(table(row(), fails, far, near)).tolist() == [True, False, False, True]


def test_misses_and_estimates_without_a_bound_are_no_part_of_its_coverage():
    rows = [row(scene_id=i, error_bound=0.02, surface_rms=0.01 if i < 18 else 0.03, distance=3.0) for i in range(20)]
    rows += [row(scene_id=30), missed(scene_id=31)]
    found = table(*rows)
    everywhere, near = bound_coverage(found.select(found.found))
    assert (everywhere.label, everywhere.count, everywhere.fraction) == ("all", 20, 0.9)
    assert (near.label, near.count, near.median_bound) == ("2-4 m", 20, 0.02)
    assert everywhere.interval[0] < 0.9 < everywhere.interval[1]


def test_trust_comes_back_from_its_plain_form():
    rows = [
        row(scene_id=i % 5, score=i / 40, slack_lateral=0.01 if i % 3 else -0.01, error_bound=0.1) for i in range(40)
    ]
    trust = trust_of(table(*rows, missed()))
    again = Trust.read(trust.row(), "here")
    assert again.row() == trust.row()
    assert (trust.estimates, trust.failures) == (40, 14)
    assert trust.risk_at[-1] == (1.0, pytest.approx(14 / 40))


def test_trust_in_nothing_is_not_known():
    trust = trust_of(table(missed()))
    assert trust.estimates == 0
    assert Trust.read(trust.row(), "here").row()["auroc"] is None


def test_the_interval_is_that_of_scenes_laid_side_by_side():
    rng = np.random.default_rng(6)
    score, right = rng.integers(0, 6, 60) / 5.0, rng.random(60) < 0.7
    scene = np.repeat(np.arange(12), 5)
    again, slow = np.random.default_rng(1), []
    for _ in range(100):
        chosen = np.concatenate([np.flatnonzero(scene == k) for k in again.integers(12, size=12)])
        slow.append(auroc(score[chosen], right[chosen]))
    expected = np.percentile([value for value in slow if not np.isnan(value)], [2.5, 97.5])
    assert auroc_interval(score, right, scene, 100, np.random.default_rng(1)) == pytest.approx(tuple(expected))
