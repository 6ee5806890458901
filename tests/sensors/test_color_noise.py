import numpy as np
import pytest

from warehouse_sim.sensors.color_noise import add_color_noise, sigma_of_code

SHOT, READ = 0.001, 0.0001


@pytest.mark.parametrize("code", [40, 100, 180, 230])
def test_the_spread_in_linear_light_is_shot_and_read_noise(code: int) -> None:
    image = np.full((300, 300, 3), code, np.uint8)
    noisy = add_color_noise(image, np.random.default_rng(2), shot=SHOT, read=READ) / 255.0
    linear = ((noisy + 0.055) / 1.055) ** 2.4
    x = ((code / 255.0 + 0.055) / 1.055) ** 2.4
    assert linear.std() == pytest.approx(np.sqrt(SHOT * x + READ), rel=0.05)
    assert linear.mean() == pytest.approx(x, abs=0.004)
    channels = noisy.reshape(-1, 3) - noisy.mean()
    assert abs(np.corrcoef(channels.T)[0, 1]) < 0.02


def test_no_noise_returns_the_image_and_extremes_do_not_wrap() -> None:
    image = np.zeros((60, 60, 3), np.uint8)
    image[:30] = 255
    assert add_color_noise(image, np.random.default_rng(0), shot=0.0, read=0.0) is image
    noisy = add_color_noise(image, np.random.default_rng(0), shot=SHOT, read=READ)
    assert noisy[:30].min() > 200
    assert noisy[30:].max() < 110


def test_sigma_is_finite_for_black() -> None:
    assert np.isfinite(sigma_of_code(SHOT, READ)).all()
    assert (sigma_of_code(0.0, READ)[1:] <= sigma_of_code(SHOT, READ)[1:]).all()
