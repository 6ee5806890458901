"""The receiver, and the constant errors of its unit."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import with_constants
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.receiver import (
    LidarUnit,
    detection_probability,
    intensity,
    range_sigma,
    relative_power,
)


@pytest.mark.parametrize(
    ("name", "remission", "published"),
    [
        ("hdl64e", 0.1, 50.0),
        ("hdl64e", 0.8, 120.0),
        ("vlp16", 0.8, 100.0),
        ("os1_128", 0.1, 40.0),
        ("os1_128", 0.8, 120.0),
        ("safety2d", 0.1, 8.0),
    ],
)
def test_half_of_the_pulses_come_back_at_the_published_range(name: str, remission: float, published: float) -> None:
    distance = np.linspace(1.0, 200.0, 20_000)
    power = relative_power(np.full_like(distance, remission), distance, LIDAR_PRESETS[name])
    assert (np.diff(power) < 0).all()
    reach = np.interp(0.5, detection_probability(power, LIDAR_PRESETS[name])[::-1], distance[::-1])
    assert reach == pytest.approx(published, rel=0.04)


def test_detection_is_a_sigmoid_over_the_power() -> None:
    config = with_constants(LidarConfig(), detection_width=0.2)
    power = np.array([0.0, 0.6, 1.0, 1.4, 1000.0])
    expected = [1 / (1 + np.exp(5)), 1 / (1 + np.exp(2)), 0.5, 1 / (1 + np.exp(-2)), 1.0]
    np.testing.assert_allclose(detection_probability(power, config), expected)


@pytest.mark.parametrize("name", LIDAR_PRESETS)
def test_a_strong_signal_repeats_as_published(name: str) -> None:
    """From pulse to pulse: KITTI's HDL-64E 7.3-8.2 mm on the road, the others' sheets; the VLP-16 as the HDL-64E."""
    published = {"hdl64e": 0.008, "hdl64e_s2": 0.008, "vlp16": 0.008, "os1_128": 0.015, "safety2d": 0.02}
    config = LIDAR_PRESETS[name]
    assert range_sigma(np.array([50.0]), config)[0] == pytest.approx(published[config.model], rel=0.02)


@pytest.mark.parametrize(("name", "accuracy"), [("hdl64e", 0.02), ("vlp16", 0.03 / np.sqrt(3.0)), ("os1_128", 0.015)])
def test_lasers_of_units_are_as_accurate_as_published(name: str, accuracy: float) -> None:
    """One sigma of 2 cm over all lasers; even between +-3 cm; no bias but 1.5 cm of repeatability."""
    config = LIDAR_PRESETS[name]
    units = [LidarUnit.sample(config, np.random.default_rng(seed)) for seed in range(200)]
    bias = np.concatenate([unit.bias for unit in units])
    total = np.hypot(bias.std(), config.range_noise)
    assert total == pytest.approx(accuracy, rel=0.15)
    assert np.abs(bias).max() <= np.sqrt(3.0) * config.laser_bias + 1e-6
    assert config.laser_bias == 0 or not np.array_equal(units[0].bias, units[1].bias)


def test_the_os1s_sigma_grows_as_its_data_sheet_says() -> None:
    """1.5, 3 and 10 cm at ratios of signal to noise of 250, 100 and 12; the limit of detection is taken at 12."""
    sigma = range_sigma(np.array([250.0, 100.0, 12.0]) / 12.0, LIDAR_PRESETS["os1_128"])
    assert sigma[0] == pytest.approx(0.015, rel=0.06)
    assert sigma[2] == pytest.approx(0.10, rel=0.02)
    assert 0.015 < sigma[1] < 0.03


def test_intensity_is_the_reflectance_in_8_bit() -> None:
    reflectance = np.float32([0.0, 0.1, 0.4, 1.0, 2.0, 30.0])
    linear = intensity(reflectance, LidarConfig())
    np.testing.assert_allclose(linear * 255, [0, 26, 102, 255, 255, 255], atol=1e-4)
    scaled = intensity(reflectance, LIDAR_PRESETS["vlp16"])
    np.testing.assert_allclose(scaled * 255, [0, 10, 40, 100, 117, 255], atol=1e-4)


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
