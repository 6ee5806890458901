from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.sweep import make_sweep


def test_each_ring_has_its_elevation_and_covers_the_turn_once() -> None:
    sweep = make_sweep(LidarConfig())
    grid = sweep.directions.reshape(*sweep.shape, 3).astype(float)
    elevation = np.sort(LASERS["hdl64e"]().elevation)[::-1]
    np.testing.assert_allclose(np.arcsin(grid[..., 2]), np.broadcast_to(elevation[:, None], sweep.shape), atol=1e-6)
    azimuth = np.sort(np.arctan2(grid[..., 1], grid[..., 0]), axis=1)
    gap = np.degrees(np.diff(azimuth, axis=1))
    assert gap.min() == pytest.approx(0.1728, abs=1e-3)
    assert gap.max() <= 0.1728 * 4 / 3 + 1e-3  # where the turn closes: it holds 2083 and a third of the steps


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


@pytest.mark.parametrize(
    ("name", "sign"), [("hdl64e", 1), ("hdl64e_s2", 1), ("vlp16", -1), ("os1_128", -1), ("safety2d", 1)]
)
def test_heads_turn_as_their_manuals_say(name: str, sign: int) -> None:
    """VLP-16 and OS1 clockwise seen from above; KITTI's files and SICK's telegrams counter-clockwise."""
    sweep = make_sweep(LIDAR_PRESETS[name])
    middle = sweep.ring == sweep.shape[0] // 2
    order = np.argsort(sweep.time[middle], kind="stable")
    x, y, _ = sweep.directions[middle][order].astype(float).T
    turn = np.unwrap(np.arctan2(y, x))
    assert (sign * np.diff(turn) > 0).all()
    rate = np.degrees(turn[-1] - turn[0]) / 360.0 / np.ptp(sweep.time[middle])
    assert rate == pytest.approx(sign * LIDAR_PRESETS[name].turns_per_second, rel=2e-3)


@pytest.mark.parametrize("name", ["vlp16", "os1_128"])
def test_clockwise_heads_look_forward_in_the_middle_of_their_turn(name: str) -> None:
    sweep = make_sweep(LIDAR_PRESETS[name])
    lasers = LASERS[name]()
    step = 1.0 / LIDAR_PRESETS[name].turns_per_second / sweep.shape[1]
    assert sweep.forward_time == pytest.approx(0.05, abs=step)
    ring = sweep.ring == int(lasers.rings()[0])  # the first laser of a cycle fires where the head points
    x, y, _ = sweep.directions[ring].astype(float).T
    nearest = np.abs(np.arctan2(y, x) - lasers.azimuth[0]).argmin()
    assert sweep.time[ring][nearest] == pytest.approx(sweep.forward_time, abs=step)


def test_a_vlp16_looks_where_its_head_has_turned_to() -> None:
    """The manual's precise azimuth: 0.2 deg in 55.296 us, and 2.304 us from laser to laser."""
    config = LIDAR_PRESETS["vlp16"]
    sweep = make_sweep(config)
    x, y, _ = sweep.directions.astype(float).T
    expected = -360.0 * config.turns_per_second * (sweep.time.astype(float) - sweep.time.astype(float).min())
    apart = np.degrees(np.arctan2(y, x)) - expected
    apart = (apart - apart[sweep.firing_order[0]] + 180.0) % 360.0 - 180.0
    # Where the turn closes a step fits into it but in part.
    assert np.percentile(np.abs(apart), 99) < config.azimuth_step_deg
    inner = np.diff(np.sort(np.round(apart, 3)))
    assert inner.max() < config.azimuth_step_deg
