from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.sweep import make_sweep


@pytest.mark.parametrize("name", LIDAR_PRESETS)
def test_rays_are_unit_vectors_that_start_beside_the_centre(name: str) -> None:
    sweep = make_sweep(LIDAR_PRESETS[name])
    np.testing.assert_allclose(np.linalg.norm(sweep.directions, axis=1), 1.0, atol=1e-6)
    assert np.abs((sweep.origins * sweep.directions).sum(axis=1)).max() < 1e-6
    lasers = LASERS[name]()
    offset = np.hypot(lasers.up, lasers.left)[np.argsort(lasers.rings())]
    np.testing.assert_allclose(np.linalg.norm(sweep.origins, axis=1), offset[sweep.ring], atol=1e-6)


def test_each_ring_has_its_elevation_and_covers_the_turn_once() -> None:
    sweep = make_sweep(LidarConfig())
    grid = sweep.directions.reshape(*sweep.shape, 3).astype(float)
    elevation = np.sort(LASERS["hdl64e"]().elevation)[::-1]
    np.testing.assert_allclose(np.arcsin(grid[..., 2]), np.broadcast_to(elevation[:, None], sweep.shape), atol=1e-6)
    azimuth = np.sort(np.arctan2(grid[..., 1], grid[..., 0]), axis=1)
    gap = np.degrees(np.diff(azimuth, axis=1))
    assert gap.min() == pytest.approx(0.1728, abs=1e-3)
    assert gap.max() <= 0.1728 * 4 / 3 + 1e-3  # where the turn closes: it holds 2083 and a third of the steps


def test_a_column_of_the_grid_looks_one_way() -> None:
    sweep = make_sweep(LidarConfig())
    grid = sweep.directions.reshape(*sweep.shape, 3)
    azimuth = np.arctan2(grid[..., 1], grid[..., 0])[:, 1:-1]
    assert np.degrees(np.ptp(azimuth, axis=0)).max() <= 0.1728 + 1e-3


def test_rays_fire_in_time_where_the_head_points() -> None:
    """Time is that of the head's azimuth, from which each laser looks aside, plus the laser's own delay."""
    sweep, lasers = make_sweep(LidarConfig()), LASERS["hdl64e"]()
    assert (np.diff(sweep.time[sweep.firing_order]) >= 0).all()
    assert sorted(sweep.firing_order) == list(range(len(sweep.time)))
    x, y, _ = sweep.directions.T.astype(float)
    laser = np.argsort(lasers.rings())[sweep.ring]
    head = np.arctan2(y, x) - lasers.azimuth[laser] + np.pi
    # A turn takes 0.1 s; where it closes, a step fits into it but for a third.
    seconds = (head / (2 * np.pi) % 1.0) * 0.1 + lasers.delay[laser]
    apart = np.abs(seconds - sweep.time)
    assert np.minimum(apart, 0.1 - apart).max() < 48e-6
    assert sweep.forward_time == pytest.approx(0.05, abs=48e-6)


def test_part_of_a_turn_stays_within_its_limits() -> None:
    config = replace(LidarConfig(), azimuth_range_deg=(-30.0, 60.0), every_nth_beam=4)
    sweep = make_sweep(config)
    azimuth = np.degrees(np.arctan2(sweep.directions[:, 1], sweep.directions[:, 0]))
    assert azimuth.min() > -30.1
    assert azimuth.max() < 60.1
    assert sweep.shape == (16, len(np.arange(-30.0, 60.0, 0.1728)))
    assert not sweep.closed
    assert sweep.time.min() >= 0
    assert sweep.ring.max() == 15


def test_the_planar_scanner_sees_270_degrees_in_its_plane() -> None:
    sweep = make_sweep(LIDAR_PRESETS["safety2d"])
    azimuth = np.degrees(np.arctan2(sweep.directions[:, 1], sweep.directions[:, 0]))
    np.testing.assert_allclose(azimuth, np.arange(-135.0, 136.0), atol=1e-4)
    assert (sweep.directions[:, 2] == 0).all()
    assert np.ptp(sweep.time) == pytest.approx(270 / 360 / 15, rel=1e-5)
