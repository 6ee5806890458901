"""Constant errors of a unit, and phases of sweeps, seen from the points alone."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.receiver import LidarUnit

STILL = replace(LidarConfig(), divergence_mrad=(0.0, 0.0), range_step=0.0, azimuth_range_deg=(-20.0, 20.0))


@pytest.fixture(scope="module")
def wall() -> RayCaster:
    """A wall with its face at x = 10, wide and high."""
    return RayCaster(make_scene([box_model("wall", (1, 80, 80))], [("wall", at(10.5, 0, 0))]))


def range_errors(result: LidarScan) -> np.ndarray:
    """Return how much too far the points are along their rays (m), but for the lasers' places beside the origin."""
    points = result.points.astype(float)
    return (points[:, 0] - 10.0) * np.linalg.norm(points, axis=1) / points[:, 0]


def test_a_units_lasers_are_off_by_as_much_in_every_sweep(wall: RayCaster) -> None:
    unit = LidarUnit.sample(STILL, np.random.default_rng(3))
    means = []
    for seed in range(2):
        result = scan(wall, STILL, at(0, 0, 0), np.random.default_rng(seed), unit=unit)
        errors = range_errors(result)
        means.append(np.array([errors[result.ring == ring].mean() for ring in range(64)]))
    sweeps = np.array(means)
    assert np.abs(sweeps[0] - sweeps[1]).max() < 6 * STILL.range_noise * np.sqrt(2.0 / 230)
    assert np.abs(sweeps.mean(axis=0) - unit.bias).max() < 0.006  # rings of a unit, and a few mm of their origins
    assert sweeps.mean(axis=0).std() == pytest.approx(STILL.laser_bias, rel=0.2)


def test_noise_from_pulse_to_pulse_stays_beside_the_bias(wall: RayCaster) -> None:
    result = scan(
        wall, STILL, at(0, 0, 0), np.random.default_rng(0), unit=LidarUnit.sample(STILL, np.random.default_rng(3))
    )
    errors = range_errors(result)
    within = [errors[result.ring == ring].std() for ring in range(64)]
    assert np.median(within) == pytest.approx(STILL.range_noise, rel=0.15)


def test_every_nth_beam_keeps_its_own_errors() -> None:
    whole = LidarUnit.sample(STILL, np.random.default_rng(3))
    part = LidarUnit.sample(replace(STILL, every_nth_beam=4), np.random.default_rng(3))
    np.testing.assert_array_equal(part.bias, whole.bias[::4])
    np.testing.assert_array_equal(part.gain, whole.gain[::4])


@pytest.mark.parametrize(("name", "moves"), [("hdl64e", True), ("vlp16", True), ("os1_128", False)])
def test_azimuths_differ_from_sweep_to_sweep_but_not_of_an_encoder(wall: RayCaster, name: str, moves: bool) -> None:
    config = replace(LIDAR_PRESETS[name].ideal(), azimuth_phase=LIDAR_PRESETS[name].azimuth_phase)
    step, phases = config.azimuth_step_deg, []
    for seed in range(12):
        points = scan(wall, config, at(0, 0, 0), np.random.default_rng(seed)).points.astype(float)
        ahead = points[(points[:, 0] > 0) & (np.abs(points[:, 2]) < 0.6)]
        azimuth = np.degrees(np.arctan2(ahead[:, 1], ahead[:, 0]))
        phases.append(azimuth[np.abs(azimuth).argmin()] % step)
    assert (np.ptp(phases) > 0.3 * step) == moves
