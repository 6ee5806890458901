import numpy as np
import pytest

from warehouse_sim.sensors.rgbd.depth.noise import odd_window, unit_noise

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
