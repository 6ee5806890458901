"""The fit of uncertainty: sums of steps against scikit-learn's own predictions, and bounds against made errors."""

import numpy as np
import pytest

from trainings import uncertainty_fit
from trainings.uncertainty_samples import Samples, joined
from warehouse_sim.estimators.pose.uncertainty.model import Uncertainty, read_uncertainty, write_uncertainty

NAMES = ("log_range", "noise", "nothing")


def made(count: int, seed: int) -> Samples:
    """Errors whose spread follows the noise, of a covariance that does not know it; wrong where it is large."""
    rng = np.random.default_rng(seed)
    distance, noise = rng.uniform(1.0, 12.0, count), rng.uniform(-1.0, 1.0, count)
    error = np.abs(rng.normal(size=count)) * 0.01 * np.exp(noise)
    features = np.column_stack([np.log(distance), noise, rng.normal(size=count)])
    covariance = np.tile(np.diag([1e-4, 0, 0, 0, 0, 0]), (count, 1, 1))
    metric = np.tile(np.eye(6), (count, 1, 1))
    scene = np.arange(count) // 10
    return Samples(NAMES, features, covariance, metric, error, error < 0.012, distance, scene, np.array(["a"] * count))


def test_steps_are_what_scikit_learn_predicts(monkeypatch):
    from sklearn.ensemble import GradientBoostingClassifier

    monkeypatch.setattr(uncertainty_fit, "_ROUNDS", 40)
    samples = made(400, 0)
    weight = np.ones(400)
    fitted = GradientBoostingClassifier(n_estimators=40, **uncertainty_fit._BOOST)
    fitted.fit(samples.features, samples.right, sample_weight=weight)
    steps = uncertainty_fit._named(uncertainty_fit._classify(samples.features, samples.right, weight), NAMES)
    fresh = made(300, 1).features
    found = uncertainty_fit.evaluate_steps(steps, list(NAMES), fresh)
    assert found == pytest.approx(fitted.decision_function(fresh), abs=1e-3)
    one = steps.value(dict(zip(NAMES, map(float, fresh[7]), strict=True)))
    assert one == pytest.approx(found[7])


def test_bounds_follow_the_regime_and_hold_in_nine_of_ten_new_cases(monkeypatch, tmp_path):
    monkeypatch.setattr(uncertainty_fit, "_ROUNDS", 80)
    write_uncertainty(tmp_path, Uncertainty((uncertainty_fit.fit(made(2000, 0), "argmax", "none"),)))
    model = read_uncertainty(tmp_path).get("argmax", "none")
    fresh = made(2000, 1)
    rows = [dict(zip(NAMES, map(float, row), strict=True)) for row in fresh.features]
    bound = uncertainty_fit.of_readings(fresh) * [model.bound_factor(row) for row in rows]
    holds = fresh.error <= bound
    noise = fresh.features[:, 1]
    for low, high in ((-1.0, -0.5), (-0.5, 0.0), (0.0, 0.5), (0.5, 1.0)):
        assert holds[(noise >= low) & (noise < high)].mean() == pytest.approx(0.9, abs=0.05)
    assert np.median(bound[noise > 0.5]) > 2.0 * np.median(bound[noise < -0.5])
    assert model.coverage == pytest.approx(0.9, abs=0.02)


def test_each_group_weighs_the_same():
    weight = uncertainty_fit._weights(np.array(["a"] * 30 + ["b"] * 10))
    assert weight[:30].sum() == pytest.approx(weight[30:].sum())


def test_samples_come_back_from_their_file(tmp_path):
    samples = made(20, 0)
    samples.save(tmp_path / "new" / "a.npz")
    again = Samples.load(tmp_path / "new" / "a.npz")
    assert again.names == NAMES
    assert np.array_equal(again.features, samples.features)
    assert len(joined([samples, again]).error) == 40
