import numpy as np
import pytest

from warehouse_sim.sensors.depth_noise import disturb_depth, unit_noise

SIZE = (400, 500)


def noisy(depth: np.ndarray, **options: float) -> np.ndarray:
    settings = {"sigma_base": 0.0, "sigma_quadratic": 0.0, "correlation_px": 1, "inverse_depth_step": 0.0, **options}
    return disturb_depth(depth.astype(np.float32), np.random.default_rng(5), **settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("z", [0.5, 2.0, 8.0])
@pytest.mark.parametrize("window", [1, 5, 9])
def test_the_spread_is_that_of_the_formula_whatever_the_window(z: float, window: int) -> None:
    sigma = 0.001 + 0.002 * z * z
    error = noisy(np.full(SIZE, z), sigma_base=0.001, sigma_quadratic=0.002, correlation_px=window) - z
    assert error.std() == pytest.approx(sigma, rel=0.05)
    assert abs(error.mean()) < 5 * sigma * window / np.sqrt(error.size)


def test_noise_is_alike_within_the_window_and_not_beyond() -> None:
    noise = unit_noise(SIZE, np.random.default_rng(1), 5)
    assert noise.shape == SIZE
    for shift, expected in ((1, 0.8), (2, 0.6), (4, 0.2), (5, 0.0), (9, 0.0)):
        # Two means over windows of five share 5 - shift of five columns.
        assert np.mean(noise[:, shift:] * noise[:, :-shift]) == pytest.approx(expected, abs=0.03)
    white = unit_noise(SIZE, np.random.default_rng(1), 1)
    assert np.mean(white[:, 1:] * white[:, :-1]) == pytest.approx(0.0, abs=0.01)


def test_steps_of_inverse_depth_grow_with_the_square_of_depth() -> None:
    depth = np.tile(np.linspace(1.0, 10.0, 5000), (2, 1))
    stepped = noisy(depth, inverse_depth_step=0.01)
    np.testing.assert_allclose(np.rint(100.0 / stepped), 100.0 / stepped, rtol=1e-5)
    assert (np.abs(1.0 / stepped - 1.0 / depth) <= 0.005 + 1e-6).all()


def test_without_settings_depth_is_the_truth_and_nothing_stays_nothing() -> None:
    depth = np.random.default_rng(0).uniform(0.5, 9, SIZE).astype(np.float32)
    depth[:50] = 0.0
    assert np.array_equal(noisy(depth), depth)
    disturbed = noisy(depth, sigma_base=0.5, sigma_quadratic=0.1, correlation_px=3, inverse_depth_step=0.01)
    assert (disturbed[:50] == 0.0).all()
    assert disturbed.min() >= 0.0
    assert disturbed.dtype == np.float32
