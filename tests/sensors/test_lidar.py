import numpy as np
import pytest

from tests.render.scenes import at, box_model, make_scene, rack_wall
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.sensors.lidar import LidarConfig, beam_directions, scan
from warehouse_sim.sensors.rig import RigConfig

QUIET = LidarConfig(range_noise=0.0)


@pytest.fixture(scope="module")
def plain() -> RayCaster:
    """A wide floor at z = 0 and a wall with its face at x = 10."""
    models = [box_model("floor", (400, 400, 1), "concrete"), box_model("wall", (1, 400, 20), "steel")]
    return RayCaster(make_scene(models, [("floor", at(0, 0, -0.5)), ("wall", at(10.5, 0, 10))]))


def test_the_beams_span_what_the_data_sheet_says() -> None:
    directions = beam_directions(QUIET).reshape(-1, 64, 3)
    assert len(directions) == round(360 / 0.1728)
    elevation = np.degrees(np.arcsin(directions[0, :, 2]))
    assert (elevation[0], elevation[-1]) == pytest.approx((2.0, -24.9))
    assert np.diff(elevation[:32]) == pytest.approx(-1 / 3, abs=0.001)
    assert np.diff(elevation[32:]) == pytest.approx(-0.518, abs=0.001)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0)
    azimuth = np.degrees(np.arctan2(directions[:, 0, 1], directions[:, 0, 0]))
    assert len(np.unique(np.round(azimuth, 3))) == len(azimuth)


def test_a_sweep_over_floor_and_wall_equals_the_closed_form(plain: RayCaster) -> None:
    T_world_lidar = at(0, 0, 1.73)
    result = scan(plain, QUIET, T_world_lidar, np.random.default_rng(0))
    world = transform_points(T_world_lidar, result.points.astype(float))
    on_floor, on_wall = result.instance_ids == 1, result.instance_ids == 2
    assert on_floor.sum() > 10_000
    assert on_wall.sum() > 10_000
    assert (on_floor | on_wall).all()
    assert np.abs(world[on_floor, 2]).max() < 1e-4
    assert np.abs(world[on_wall, 0] - 10.0).max() < 1e-4
    distance = np.linalg.norm(result.points, axis=1)
    assert distance.max() <= 120.0
    np.testing.assert_allclose(result.intensity[on_floor], 0.35 * 1.73 / distance[on_floor], rtol=1e-3)
    np.testing.assert_allclose(
        result.intensity[on_wall], 0.6 * result.points[on_wall, 0] / distance[on_wall], rtol=1e-3
    )


def test_rings_count_from_the_top_in_firing_order(plain: RayCaster) -> None:
    result = scan(plain, QUIET, at(0, 0, 1.73), np.random.default_rng(0))
    elevation = np.degrees(np.arcsin(result.points[:, 2] / np.linalg.norm(result.points, axis=1)))
    expected = np.concatenate([np.linspace(2.0, -8.33, 32), np.linspace(-8.83, -24.9, 32)])
    np.testing.assert_allclose(elevation, expected[result.ring], atol=1e-3)
    azimuth = np.unwrap(np.arctan2(result.points[:, 1], result.points[:, 0]).astype(float))
    assert (np.diff(azimuth) > -1e-4).all()


def test_noise_moves_points_along_their_rays_by_its_sigma(plain: RayCaster) -> None:
    quiet = scan(plain, QUIET, at(0, 0, 1.73), np.random.default_rng(0))
    noisy = scan(plain, LidarConfig(range_noise=0.03), at(0, 0, 1.73), np.random.default_rng(0))
    again = scan(plain, LidarConfig(range_noise=0.03), at(0, 0, 1.73), np.random.default_rng(0))
    assert np.array_equal(noisy.points, again.points)
    distance, measured = np.linalg.norm(quiet.points, axis=1), np.linalg.norm(noisy.points, axis=1)
    assert len(distance) == len(measured)
    assert (measured - distance).std() == pytest.approx(0.03, rel=0.03)
    cosine = (quiet.points * noisy.points).sum(axis=1) / (distance * measured)
    assert cosine.min() > 1.0 - 1e-6


def test_range_limits_and_field_of_view_hold(plain: RayCaster) -> None:
    config = LidarConfig(azimuth_range_deg=(-30.0, 60.0), min_range=5.0, max_range=11.0, every_nth_beam=4)
    result = scan(plain, config, at(0, 0, 1.73), np.random.default_rng(0))
    distance = np.linalg.norm(result.points, axis=1)
    azimuth = np.degrees(np.arctan2(result.points[:, 1], result.points[:, 0]))
    assert 4.99 < distance.min() < 5.4
    assert 10.8 < distance.max() < 11.01
    assert azimuth.min() > -30.01
    assert azimuth.max() < 60.01
    assert result.ring.max() < 16
    assert len(beam_directions(config)) == 16 * len(np.arange(-30.0, 60.0, 0.1728))


def test_points_fall_on_what_the_camera_of_the_rig_sees() -> None:
    """Point -> camera frame -> ray from the camera: the same object at the same place, but for parallax at edges."""
    scene, rig = rack_wall(), RigConfig(lidar=QUIET)
    caster, camera = RayCaster(scene), rig.make_camera()
    T_world_camera = scene.viewpoints[0].T_world_camera
    result = scan(caster, QUIET, T_world_camera @ rig.T_camera_lidar(), np.random.default_rng(0))
    points = transform_points(rig.T_camera_lidar(), result.points.astype(float))
    ahead = points[:, 2] > 0.5
    u, v = camera.project(points[ahead]).T
    in_image = (u > 0) & (u < camera.width - 1) & (v > 0) & (v < camera.height - 1)
    seen, ids = points[ahead][in_image], result.instance_ids[ahead][in_image]
    assert len(seen) > 3000
    origin = np.broadcast_to(T_world_camera[:3, 3], seen.shape)
    hits = caster.cast(origin, seen @ T_world_camera[:3, :3].T)
    same = np.abs(hits.distance - 1.0) < 1e-4
    assert same.mean() > 0.9
    assert (hits.instance_ids == ids)[same].mean() > 0.999


@pytest.mark.parametrize(
    "settings",
    [{"azimuth_step_deg": 0.0}, {"azimuth_range_deg": (10.0, 5.0)}, {"every_nth_beam": 0}, {"max_range": 0.1}],
)
def test_impossible_settings_are_refused_by_name(settings: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(settings))):
        LidarConfig(**settings)
