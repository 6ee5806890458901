import numpy as np
import pytest

from warehouse_sim.sensors.rgbd.color.pixels import add_noise


@pytest.mark.parametrize("x", [0.0, 0.02, 0.18, 1.0])
@pytest.mark.parametrize("gain", [1.0, 8.0])
def test_the_variance_is_that_of_shot_and_read_noise(x: float, gain: float) -> None:
    clean = np.full((300, 300, 3), x, np.float32)
    noise = add_noise(clean, np.random.default_rng(2), shot=1e-4, read=1e-5, gain=gain) - clean
    assert noise.var() == pytest.approx(gain * 1e-4 * x + gain**2 * 1e-5, rel=0.03)
    assert abs(noise.mean()) < 5 * noise.std() / np.sqrt(noise.size)
    assert abs(np.corrcoef(noise.reshape(-1, 3).T)[0, 1]) < 0.02
    assert abs(np.corrcoef(noise[:, 1:].ravel(), noise[:, :-1].ravel())[0, 1]) < 0.02


def test_without_noise_nothing_is_drawn() -> None:
    clean = np.ones((4, 5, 3), np.float32)
    assert add_noise(clean, np.random.default_rng(0), shot=0.0, read=0.0, gain=4.0) is clean
