"""Covariances against closed forms and against many random motions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.uncertainty.covariance import Residuals, information, rms_quantile, surface_metric
from warehouse_sim.estimators.pose.uncertainty.estimator import look_into
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import make_transform, rotation_z

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


# Rays into the openings of a box-shaped portal: open, blocked on one side, hidden.


CAMERA = PinholeCamera.from_focal(320, 200, 400.0)
# Object frame as a camera at 3 m looks along its x: camera z = object x, camera x = -object y, camera y = -object z.
AXES = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
T = make_transform(AXES, np.array([0.0, 0.0, 3.0]))


def box(low, high) -> TriangleMesh:
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    return TriangleMesh(unit_box().vertices * (high - low) + (low + high) / 2, unit_box().faces)


# A deck on three walls: two openings 0.3 m wide and 0.2 m high, through and through.
WALLS = [
    box((-0.5, -0.45, 0.1), (0.5, 0.45, 0.15)),
    *(box((-0.5, y - 0.05, -0.1), (0.5, y + 0.05, 0.1)) for y in (-0.4, 0.0, 0.4)),
]
PORTAL = merge(WALLS)


def seen(*solids: TriangleMesh, noise: float = 0.0, wall: float = 6.0) -> RgbdImage:
    """Return an image by another road: each pixel's ray against each box by its slabs."""
    rays = CAMERA.rays().reshape(-1, 3)
    depth = np.full(len(rays), wall)
    for solid in solids:
        low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        corners = np.array([low, high]) @ T[:3, :3].T + T[:3, 3]
        low, high = corners.min(axis=0), corners.max(axis=0)
        with np.errstate(divide="ignore"):
            one, other = low / rays, high / rays
        enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
        depth = np.where((leave > enter) & (enter > 0), np.minimum(depth, enter), depth)
    depth += noise * np.random.default_rng(1).standard_normal(len(depth))
    return RgbdImage(CAMERA, depth.reshape(200, 320).astype(np.float32), ())


LEFT = ((-0.4, 0.06, -0.1), (-0.1, 0.34, 0.08))


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_open_openings_have_room(noise: float) -> None:
    room = look_into(T, PORTAL, seen(*WALLS, noise=noise), np.random.default_rng(0))
    assert min(room.rays) > 50
    assert max(room.ended) < 0.05 * min(room.rays)
    assert not room.blocked


@pytest.mark.parametrize(
    "thing", [LEFT, ((-0.9, 0.06, -0.1), (-0.6, 0.34, 0.08)), ((0.1, 0.06, -0.1), (0.3, 0.34, 0.1))]
)
def test_a_thing_in_one_opening_or_close_before_it_blocks(thing) -> None:
    room = look_into(T, PORTAL, seen(*WALLS, box(*thing), noise=0.01), np.random.default_rng(0))
    assert room.blocked
    # The other one is open.
    left, right = (ended / rays for ended, rays in zip(room.ended, room.rays, strict=True))
    assert max(left, right) > 0.6
    assert min(left, right) < 0.1


def test_what_hides_from_afar_blocks_nothing_and_what_is_not_seen_is_not_told() -> None:
    hidden = seen(*WALLS, box((-2.0, -0.45, -0.3), (-1.9, 0.45, 0.3)))
    room = look_into(T, PORTAL, hidden, np.random.default_rng(0))
    assert sum(room.rays) == 0
    assert not room.blocked
    nothing = RgbdImage(CAMERA, np.zeros((200, 320), dtype=np.float32), ())
    assert not look_into(T, PORTAL, nothing, np.random.default_rng(0)).blocked


def test_a_wall_where_openings_should_be_blocks() -> None:
    wall = box((-0.5, -0.45, -0.1), (0.5, 0.45, 0.15))
    assert look_into(T, PORTAL, seen(wall), np.random.default_rng(0)).blocked
    turned = T @ make_transform(rotation_z(np.pi), np.zeros(3))
    assert look_into(turned, PORTAL, seen(wall), np.random.default_rng(0)).blocked
