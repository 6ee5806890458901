"""The filter against closed forms: information-weighted means, common errors that stay, poses that turn."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warehouse_sim.estimators.tracking.belief import Belief, Measurement, difference, mahalanobis, moved
from warehouse_sim.geometry.pose import make_transform

NOTHING = np.zeros((6, 1))


def spd(rng: np.random.Generator, scale: float = 0.01) -> np.ndarray:
    root = rng.standard_normal((6, 6)) * scale
    return root @ root.T + np.eye(6) * scale**2


def shifts(rng: np.random.Generator, count: int) -> list[Measurement]:
    """Measurements of a pose whose turn is known, so that all is linear."""
    found = []
    for _ in range(count):
        own = np.zeros((6, 6))
        own[:3, :3], own[3:, 3:] = spd(rng)[:3, :3], spd(rng)[3:, 3:]
        found.append(Measurement(make_transform(None, rng.normal(0, 0.02, 3)), own, NOTHING))
    return found


def test_a_constant_pose_is_the_information_weighted_mean() -> None:
    measured = shifts(np.random.default_rng(0), 7)
    belief = Belief.of(measured[0])
    for item in measured[1:]:
        belief = belief.updated(item)
    information = sum(np.linalg.inv(item.own) for item in measured)
    mean = np.linalg.solve(
        information[:3, :3], sum(np.linalg.inv(item.own)[:3, :3] @ item.T_world_object[:3, 3] for item in measured)
    )
    np.testing.assert_allclose(belief.T_world_object[:3, 3], mean, atol=1e-12)
    np.testing.assert_allclose(belief.information, information, rtol=1e-10)
    np.testing.assert_allclose(belief.covariance, np.linalg.inv(information), rtol=1e-8, atol=1e-15)
    # Order is no matter.
    again = Belief.of(measured[-1])
    for item in measured[-2::-1]:
        again = again.updated(item)
    np.testing.assert_allclose(again.T_world_object, belief.T_world_object, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 10, 1000])
def test_a_common_error_is_not_averaged_away(count: int) -> None:
    """n estimates with own variance s^2 and one bias b have the variance s^2 / n + b^2."""
    own, bias = np.eye(6) * 0.01**2, np.zeros((6, 1))
    bias[0] = 0.004
    belief = Belief.of(Measurement(np.eye(4), own, bias))
    for _ in range(count - 1):
        belief = belief.updated(Measurement(np.eye(4), own, bias))
    expected = np.eye(6) * 0.01**2 / count
    expected[0, 0] += 0.004**2
    np.testing.assert_allclose(belief.covariance, expected, atol=1e-14)


def test_what_both_share_does_not_set_them_apart() -> None:
    own, bias = np.eye(6) * 0.01**2, np.ones((6, 2)) * 0.05
    belief = Belief.of(Measurement(np.eye(4), own, bias))
    np.testing.assert_allclose(belief.apart(Measurement(np.eye(4), own, bias)), 2 * own, atol=1e-14)
    np.testing.assert_allclose(
        belief.apart(Measurement(np.eye(4), own, -bias)), 2 * own + 4 * bias @ bias.T, atol=1e-14
    )


def test_a_weight_of_nothing_changes_nothing() -> None:
    first, second = shifts(np.random.default_rng(3), 2)
    belief = Belief.of(first).updated(second, 0.0)
    np.testing.assert_allclose(belief.T_world_object, first.T_world_object, atol=1e-15)
    np.testing.assert_allclose(belief.covariance, Belief.of(first).covariance)


def test_drift_adds_to_what_is_averaged_alone() -> None:
    bias = np.zeros((6, 1))
    bias[2] = 0.01
    before = Belief.of(Measurement(np.eye(4), np.eye(6) * 1e-4, bias))
    after = before.after(0.02**2)
    expected = before.covariance + np.diag([0.02**2] * 3 + [0.0] * 3)
    np.testing.assert_allclose(after.covariance, expected, atol=1e-12)
    assert before.after(0.0) is before


def test_differences_lead_back() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        T = make_transform(Rotation.random(rng=rng).as_matrix(), rng.normal(0, 1, 3))
        step = rng.normal(0, 0.3, 6)
        np.testing.assert_allclose(difference(moved(T, step), T), step, atol=1e-12)
    assert mahalanobis(np.array([2.0, 0, 0, 0, 0, 0]), np.eye(6)) == pytest.approx(4.0)
