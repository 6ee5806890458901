"""Noise that neighbours share, and what is constant in one built camera."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of, plane
from warehouse_sim.sensors.rgbd.depth.noise import (
    gaussian_noise,
    odd_window,
    unit_noise,
    unit_pattern,
    unit_samples,
    wiggle,
)
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight

SIZE = (400, 500)


def test_noise_is_alike_within_the_window_and_not_beyond() -> None:
    noise = unit_noise(SIZE, np.random.default_rng(1), 5)
    assert noise.shape == SIZE
    for shift, expected in ((1, 0.8), (2, 0.6), (4, 0.2), (5, 0.0), (9, 0.0)):
        # Two means over windows of five share 5 - shift of five columns.
        assert np.mean(noise[:, shift:] * noise[:, :-shift]) == pytest.approx(expected, abs=0.03)
    white = unit_noise(SIZE, np.random.default_rng(1), 1)
    assert np.mean(white[:, 1:] * white[:, :-1]) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("size", "expected"), [(0.3, 1), (1.0, 1), (1.9, 1), (2.5, 3), (7.0, 7), (11.9, 11), (12.1, 13)]
)
def test_the_window_is_the_nearest_odd_number(size: float, expected: int) -> None:
    assert odd_window(size) == expected


CAPTURE = capture_of()
STILL = TimeOfFlight(noise_scale=0.0, multipath=0.0, sigma_lateral_px=0.0, max_range=9.0, focal_px=585.5)


def error(model: TimeOfFlight, z: float = 1.0, seed: int = 0) -> np.ndarray:
    return model.read(plane(z), CAPTURE, np.random.default_rng(seed)) - np.float32(z)


def test_a_unit_has_its_pattern_in_every_image_and_another_unit_another() -> None:
    model = replace(STILL, fixed_pattern=0.01, smooth_px=1.2)
    first, later, other = error(model), error(model, seed=5), error(replace(model, unit=7))
    assert np.array_equal(first, later)
    assert np.abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.05
    assert first.std() == pytest.approx(0.01, rel=0.05)
    np.testing.assert_allclose(error(model, 2.0), 2 * first, atol=1e-5)
    assert np.array_equal(unit_pattern(3, (20, 30), 0.0), unit_pattern.__wrapped__(3, (20, 30), 0.0))


def test_units_differ_by_offset_and_scale_as_they_are_drawn() -> None:
    offsets = [float(error(replace(STILL, unit_offset=0.01, unit=unit)).mean()) for unit in range(60)]
    assert np.std(offsets) == pytest.approx(0.01, rel=0.3)
    scales = [float(error(replace(STILL, unit_scale=0.003, unit=unit), 4.0).mean()) for unit in range(60)]
    assert np.std(scales) == pytest.approx(0.012, rel=0.3)


def test_the_cyclic_error_runs_four_times_through_the_unambiguous_range() -> None:
    ranges = np.linspace(0.1, 7.4, 4000, dtype=np.float32)[None]
    phase = unit_samples(4)[2]
    np.testing.assert_allclose(wiggle(ranges, 7.5, phase), np.sin(4 * 2 * np.pi * ranges / 7.5 + phase), atol=0.01)
    model = replace(STILL, wiggle=0.004, unit=4)
    for z in (0.5, 1.3, 3.1):
        assert error(model, z).mean() == pytest.approx(0.004 * np.sin(4 * 2 * np.pi * z / 7.5 + phase), abs=5e-5)


@pytest.mark.parametrize("smooth_px", [0.7, 1.2, 3.0])
def test_smoothed_noise_has_variance_one_and_the_likeness_of_a_gaussian_filter(smooth_px: float) -> None:
    noise = gaussian_noise((600, 800), np.random.default_rng(2), smooth_px)
    assert noise.std() == pytest.approx(1.0, rel=0.04)
    for lag in (1, 2, 3):
        alike = float((noise[:, lag:] * noise[:, :-lag]).mean())
        assert alike == pytest.approx(np.exp(-(lag**2) / (4 * smooth_px**2)), abs=0.04)
