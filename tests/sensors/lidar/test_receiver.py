import numpy as np
import pytest

from tests.sensors.targets import with_constants
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig
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
