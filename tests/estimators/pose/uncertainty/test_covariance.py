"""Covariances against closed forms and against many random motions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from warehouse_sim.estimators.pose.uncertainty.covariance import Residuals, information, rms_quantile, surface_metric
from warehouse_sim.geometry.pose import make_transform

NINE_OF_TEN = 1.2815515655446004


def wall(points: np.ndarray, noise: float, correlated_px: float) -> Residuals:
    """Readings of a wall across the ray."""
    count = len(points)
    gradient = np.tile([0.0, 0.0, -1.0], (count, 1))
    return Residuals(points, gradient, np.zeros(count), np.ones(count, dtype=bool), noise, correlated_px)


def test_a_wall_fixes_its_distance_and_its_lean_and_nothing_else():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-0.6, 0.6, (400, 2)), np.zeros(400)])
    T = make_transform(None, np.array([0.0, 0.0, 5.0]))
    sigma = np.sqrt(np.diag(np.linalg.inv(information(wall(points, 0.01, 1.0), 400, T, None))))
    # The error of a mean, and of a slope: sigma / sqrt(n) and sigma / sqrt(sum of squares).
    assert sigma[2] == pytest.approx(0.01 / np.sqrt(400), rel=0.02)
    assert sigma[3] == pytest.approx(0.01 / np.sqrt((points[:, 1] ** 2).sum()), rel=0.02)
    # Nothing says where it is along itself, nor how it is turned about the ray: that is left to the prior.
    assert sigma[[0, 1, 5]] == pytest.approx([0.3, 0.3, 0.35], rel=0.01)


def test_readings_that_share_an_error_count_once():
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (400, 3))
    T = make_transform(None, np.array([0.0, 0.0, 5.0]))
    alone, shared = (np.linalg.inv(information(wall(points, 0.01, px), 4000, T, None)) for px in (1.0, 40.0))
    # 4000 readings with 40 to an error: 100 errors, a quarter of the 400 that are looked at.
    assert np.sqrt(shared[2, 2] / alone[2, 2]) == pytest.approx(2.0, rel=0.01)


def test_gravity_says_how_an_object_leans_and_not_where_it_faces():
    nothing = wall(np.zeros((1, 3)), 1000.0, 1.0)
    down = np.array([0.0, 1.0, 0.0])
    upright = make_transform(Rotation.from_euler("x", 90, degrees=True).as_matrix(), np.array([0.0, 0.0, 5.0]))
    upright[:3, 2] = -down
    sigma = np.sqrt(np.diag(np.linalg.inv(information(nothing, 1, upright, down))))
    assert sigma[[3, 5]] == pytest.approx(np.deg2rad(0.4), rel=0.01)
    assert sigma[4] == pytest.approx(0.35, rel=0.01)


def test_the_metric_is_the_mean_squared_distance_of_a_small_motion():
    rng = np.random.default_rng(2)
    points = rng.uniform(-0.5, 0.5, (500, 3)) * [1.2, 0.8, 0.14] + [0.1, 0.0, 0.07]
    T = make_transform(Rotation.from_rotvec([0.4, -1.0, 0.3]).as_matrix(), np.array([0.3, -0.2, 4.0]))
    metric = surface_metric(T, points.mean(axis=0), np.cov(points.T, bias=True))
    motion = 1e-4 * rng.normal(size=6)
    turned = Rotation.from_rotvec(motion[3:]).as_matrix() @ T[:3, :3]
    moved = points @ turned.T + T[:3, 3] + motion[:3] - (points @ T[:3, :3].T + T[:3, 3])
    assert motion @ metric @ motion == pytest.approx((moved**2).sum(axis=1).mean(), rel=1e-3)


@pytest.mark.parametrize("degrees_of_freedom", [1, 3, 6])
def test_the_quantile_of_equal_variances_is_that_of_chi_squared(degrees_of_freedom):
    covariance = np.diag([0.02**2] * degrees_of_freedom + [0.0] * (6 - degrees_of_freedom))
    wanted = 0.02 * np.sqrt(chi2.ppf(0.9, degrees_of_freedom))
    # The formula of Wilson and Hilferty is 1.3 % low at one degree of freedom.
    assert rms_quantile(covariance, np.eye(6), NINE_OF_TEN) == pytest.approx(wanted, rel=0.015)
