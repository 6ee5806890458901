from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import with_constants
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Material
from warehouse_sim.sensors.lidar import LidarConfig, scan
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.receiver import detection_probability, relative_power
from warehouse_sim.sensors.lidar.sweep import make_sweep
from warehouse_sim.sensors.motion import EgoMotion

QUIET = LidarConfig().ideal()
POSE = at(0, 0, 1.73)


@pytest.fixture(scope="module")
def plain() -> RayCaster:
    """A wide floor at z = 0 and a wall with its face at x = 10."""
    models = [box_model("floor", (400, 400, 1), "concrete"), box_model("wall", (1, 400, 20), "steel")]
    return RayCaster(make_scene(models, [("floor", at(0, 0, -0.5)), ("wall", at(10.5, 0, 10))]))


def rays_of(result: LidarScan, config: LidarConfig) -> tuple[np.ndarray, np.ndarray]:
    """Return origin and direction of each point's ray, found by ring and time."""
    sweep = make_sweep(config)
    known = {key: ray for ray, key in enumerate(zip(sweep.ring.tolist(), sweep.time.tolist(), strict=True))}
    rays = [known[key] for key in zip(result.ring.tolist(), result.time.tolist(), strict=True)]
    return sweep.origins[rays].astype(float), sweep.directions[rays].astype(float)


def test_a_sweep_over_floor_and_wall_equals_the_closed_form(plain: RayCaster) -> None:
    result = scan(plain, QUIET, POSE, np.random.default_rng(0))
    world = transform_points(POSE, result.points.astype(float))
    on_floor, on_wall = result.instance_ids == 1, result.instance_ids == 2
    assert on_floor.sum() > 10_000
    assert on_wall.sum() > 10_000
    assert (on_floor | on_wall).all()
    assert np.abs(world[on_floor, 2]).max() < 1e-4
    assert np.abs(world[on_wall, 0] - 10.0).max() < 1e-4
    origin, direction = rays_of(result, QUIET)
    assert np.abs(np.cross(result.points - origin, direction)).max() < 1e-4
    code = 0.5 / 255 + 1e-6
    np.testing.assert_allclose(result.intensity[on_floor], 0.35 * -direction[on_floor, 2], atol=code)
    np.testing.assert_allclose(result.intensity[on_wall], 0.6 * direction[on_wall, 0], atol=code)
    assert np.linalg.norm(result.points - origin, axis=1).max() <= 120.0


def test_points_come_in_firing_order_with_their_rings(plain: RayCaster) -> None:
    result = scan(plain, QUIET, POSE, np.random.default_rng(0))
    assert (np.diff(result.time) >= 0).all()
    assert 0 <= result.time.min() < result.time.max() < 0.1
    origin, _ = rays_of(result, QUIET)
    ray = result.points - origin
    elevation = np.arcsin(ray[:, 2] / np.linalg.norm(ray, axis=1))
    expected = np.sort(LASERS["hdl64e"]().elevation)[::-1]
    np.testing.assert_allclose(elevation, expected[result.ring], atol=2e-5)


def test_noise_moves_points_along_their_rays_by_its_sigma(plain: RayCaster) -> None:
    noisy_config = replace(QUIET, range_noise=0.03)
    quiet = scan(plain, QUIET, POSE, np.random.default_rng(0))
    noisy = scan(plain, noisy_config, POSE, np.random.default_rng(0))
    again = scan(plain, noisy_config, POSE, np.random.default_rng(0))
    for name in ("points", "intensity", "instance_ids", "ring", "time"):
        assert getattr(noisy, name).tobytes() == getattr(again, name).tobytes()
    assert len(quiet.points) == len(noisy.points)
    _, direction = rays_of(quiet, QUIET)
    moved = (noisy.points - quiet.points).astype(float)
    along = (moved * direction).sum(axis=1)
    assert along.std() == pytest.approx(0.03, rel=0.02)
    assert along.mean() == pytest.approx(0.0, abs=5e-4)
    assert np.abs(moved - along[:, None] * direction).max() < 1e-4
    other = scan(plain, noisy_config, POSE, np.random.default_rng(1))
    assert not np.array_equal(other.points[:100], noisy.points[:100])


def test_distances_come_in_steps_of_two_millimetres(plain: RayCaster) -> None:
    config = replace(QUIET, range_noise=0.02, range_step=0.002)
    result = scan(plain, config, POSE, np.random.default_rng(0))
    origin, direction = rays_of(result, config)
    steps = ((result.points - origin) * direction).sum(axis=1) / 0.002
    near = steps < 10_000  # beyond 20 m float32 leaves little of a step
    assert np.abs(steps - np.rint(steps))[near].max() < 0.01


def test_range_limits_and_field_of_view_hold(plain: RayCaster) -> None:
    config = replace(QUIET, azimuth_range_deg=(-30.0, 60.0), min_range=5.0, max_range=11.0, every_nth_beam=4)
    result = scan(plain, config, POSE, np.random.default_rng(0))
    origin, _ = rays_of(result, config)
    ray = result.points - origin
    distance, azimuth = np.linalg.norm(ray, axis=1), np.degrees(np.arctan2(ray[:, 1], ray[:, 0]))
    assert 4.99 < distance.min() < 5.4
    assert 10.8 < distance.max() < 11.01
    assert azimuth.min() > -30.1
    assert azimuth.max() < 60.1
    assert result.ring.max() < 16


@pytest.mark.parametrize(("remission", "distance"), [(0.1, 42.0), (0.1, 50.0), (0.1, 56.0), (0.02, 25.0), (0.4, 88.0)])
def test_dropout_follows_its_formula(remission: float, distance: float) -> None:
    thin = replace(LidarConfig(), azimuth_range_deg=(-3.0, 3.0), divergence_mrad=(0.0, 0.0))
    config = with_constants(thin, detection_width=0.2)
    materials = {"dull": Material("dull", (0.1, 0.1, 0.1), remission=remission)}
    wall = box_model("wall", (1, 200, 200), "dull")
    raycaster = RayCaster(make_scene([wall], [("wall", at(distance + 0.5, 0, 0))], materials=materials))
    directions = make_sweep(config).directions.astype(float)
    cosine = directions[:, 0]
    expected = detection_probability(relative_power(remission * cosine, distance / cosine, config), config)
    found = np.mean([len(scan(raycaster, config, at(0, 0, 0), np.random.default_rng(k)).points) for k in range(4)])
    sigma = np.sqrt((expected * (1 - expected)).sum() / 4)
    assert abs(found - expected.sum()) < 4 * sigma
    assert 0.02 < expected.mean() < 0.98


def test_a_retroreflector_shines_at_any_incidence() -> None:
    materials = {
        "foil": Material("foil", (0.5, 0.5, 0.5), remission=2.0),
        "grey": Material("grey", (0.5, 0.5, 0.5), remission=0.5),
    }
    models = [box_model("foil", (0.02, 10, 10), "foil"), box_model("grey", (0.02, 10, 10), "grey")]
    slanted = [("foil", at(5, 5.5, 0, yaw=0.9)), ("grey", at(5, -5.5, 0, yaw=-0.9))]
    result = scan(
        RayCaster(make_scene(models, slanted, materials=materials)), QUIET, at(0, 0, 0), np.random.default_rng(0)
    )
    assert (result.intensity[result.instance_ids == 1] == 1.0).all()
    assert result.intensity[result.instance_ids == 2].max() <= 0.5 + 1 / 255
    assert np.unique(result.intensity[result.instance_ids == 2]).size > 20


def test_driving_towards_a_wall_bends_the_raw_sweep_and_not_the_deskewed_one(plain: RayCaster) -> None:
    motion = EgoMotion(np.array([5.0, 0.0, 0.0]), 0.0, np.zeros(3))
    raw = scan(plain, replace(QUIET, motion="raw"), POSE, np.random.default_rng(0), motion)
    on_wall = raw.instance_ids == 2
    since = raw.time[on_wall] - make_sweep(QUIET).forward_time
    np.testing.assert_allclose(raw.points[on_wall, 0], 10.0 - 5.0 * since, atol=2e-4)
    assert np.ptp(since) > 0.02
    deskewed = scan(plain, replace(QUIET, motion="deskewed"), POSE, np.random.default_rng(0), motion)
    np.testing.assert_allclose(deskewed.points[deskewed.instance_ids == 2, 0], 10.0, atol=2e-4)
    ignored = scan(plain, replace(QUIET, motion="ignored"), POSE, np.random.default_rng(0), motion)
    still = scan(plain, QUIET, POSE, np.random.default_rng(0))
    assert ignored.points.tobytes() == still.points.tobytes()


def test_a_turning_vehicle_sees_the_wall_slanted_until_deskewed(plain: RayCaster) -> None:
    motion = EgoMotion(np.array([1.0, 0.2, 0.0]), 0.8, np.array([-1.0, 0.3, 0.0]))
    deskewed = scan(plain, replace(QUIET, motion="deskewed"), POSE, np.random.default_rng(0), motion)
    world = transform_points(POSE, deskewed.points.astype(float))
    assert np.abs(world[deskewed.instance_ids == 2, 0] - 10.0).max() < 5e-4
    assert np.abs(world[deskewed.instance_ids == 1, 2]).max() < 5e-4
    raw = scan(plain, replace(QUIET, motion="raw"), POSE, np.random.default_rng(0), motion)
    assert np.abs(raw.points[raw.instance_ids == 2, 0] - 10.0).max() > 0.1
