"""The check's law against the simulated sensor, with which it shares no code."""

import numpy as np
import pytest

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.formats.kitti.checks.lidar_law import SIGMAS, LidarLaw, in_world
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.geometry.pose import make_transform, rotation_z, transform_points
from warehouse_sim.sensors.lidar import LIDAR_PRESETS
from warehouse_sim.sensors.lidar.finishes import BrightnessConfig
from warehouse_sim.sensors.lidar.receiver import LidarUnit, intensity, intensity_factor, range_sigma, relative_power
from warehouse_sim.sensors.lidar.sweep import make_sweep
from warehouse_sim.sensors.motion import EgoMotion


def law_of(name: str, **more) -> LidarLaw:
    return LidarLaw.of(recipe_contents({"sensors": {"lidar": to_mapping(LIDAR_PRESETS[name]) | more}}).lidar)


@pytest.mark.parametrize("name", sorted(LIDAR_PRESETS))
def test_limits_cover_the_sensors_noise_and_hardly_more(name: str) -> None:
    config, rng = LIDAR_PRESETS[name], np.random.default_rng(0)
    distance = rng.uniform(2.0, min(60.0, config.max_range), 5000)
    reflectance = rng.uniform(0.02, 1.0, 5000)
    power = relative_power(reflectance, distance, config)
    most = SIGMAS * range_sigma(power, config) + np.sqrt(3.0) * config.laser_bias + config.range_step / 2
    even = to_mapping(BrightnessConfig.even())
    limit = law_of(name, brightness=even).noise_limit(distance, intensity(reflectance, config).astype(float))
    assert (limit >= most).all()
    strong = power > 2.0
    assert np.median(limit[strong] / most[strong]) < 1.1


@pytest.mark.parametrize("name", sorted(LIDAR_PRESETS))
def test_limits_hold_where_intensity_says_little_of_the_signal(name: str) -> None:
    config, rng = LIDAR_PRESETS[name], np.random.default_rng(0)
    lasers, law = len(make_sweep(config).directions) // make_sweep(config).shape[1], law_of(name)
    for seed in range(20):
        unit = LidarUnit.sample(config, np.random.default_rng(seed))
        distance = rng.uniform(2.0, min(60.0, config.max_range), 2000).astype(np.float32)
        reflectance, ring = rng.uniform(0.02, 1.0, 2000).astype(np.float32), rng.integers(0, lasers, 2000)
        sigma = range_sigma(relative_power(reflectance, distance, config), config)
        factor = intensity_factor(distance, ring.astype(np.int32), config, unit, rng)
        limit = law.noise_limit(distance.astype(float), intensity(reflectance * factor, config).astype(float))
        assert (limit >= SIGMAS * sigma + np.abs(unit.bias[ring]) + config.range_step / 2).all()


def test_a_recipe_without_a_lidar_allows_nothing() -> None:
    law = LidarLaw.of(recipe_contents({}).lidar)
    assert law.noise_limit(np.array([5.0]), np.array([0.0])).tolist() == [0.0]
    assert law.mixing_reach == law.mixed_fraction == 0.0


@pytest.mark.parametrize("name", sorted(LIDAR_PRESETS))
def test_the_head_looks_forward_when_the_sweep_says(name: str) -> None:
    sweep, law = make_sweep(LIDAR_PRESETS[name]), law_of(name, motion="raw")
    assert law.forward_time == pytest.approx(sweep.forward_time, abs=law.time_uncertainty + law.cycle_time)


@pytest.mark.parametrize("motion", ["ignored", "raw", "deskewed"])
def test_points_go_back_to_where_they_were_hit(motion: str) -> None:
    rng = np.random.default_rng(1)
    T_world_vehicle = make_transform(rotation_z(0.4), np.array([3.0, -2.0, 0.0]))
    T_world_lidar = T_world_vehicle @ make_transform(rotation_z(0.1), np.array([0.3, 0.0, 1.6]))
    seen = RecordedObservation(
        make_transform(), T_world_vehicle=T_world_vehicle, velocity=(1.5, 0.4, 0.0), yaw_rate=0.6
    )
    ego = EgoMotion(np.array(seen.velocity), seen.yaw_rate, T_world_vehicle[:3, 3])
    law = law_of("hdl64e", motion=motion)
    points, time = rng.uniform(-9.0, 9.0, (200, 3)), rng.uniform(0.0, 0.1, 200)
    still = transform_points(T_world_lidar, points)
    hits, starts = in_world(points, time, T_world_lidar, law, seen)
    since = time - law.forward_time
    lidar = np.broadcast_to(T_world_lidar[:3, 3], points.shape)
    assert np.allclose(hits, ego.carried(still, still, since)[0] if motion == "raw" else still, atol=1e-5)
    assert np.allclose(starts, lidar if motion == "ignored" else ego.carried(lidar, lidar, since)[0], atol=1e-5)
