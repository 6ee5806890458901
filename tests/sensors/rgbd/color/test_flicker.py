import numpy as np
import pytest

from warehouse_sim.sensors.rgbd.color.camera import flicker_factor


@pytest.mark.parametrize("shutter", [0.0004, 0.003, 0.013])
def test_each_row_sees_the_mean_of_the_light_while_it_is_exposed(shutter: float) -> None:
    """Against a sum over 20,000 moments of each row's exposure."""
    seen = flicker_factor(9, depth=0.3, frequency=100.0, shutter=shutter, readout=0.03, phase=0.2)[:, 0, 0]
    for row, factor in enumerate(seen):
        middle = ((row + 0.5) / 9 - 0.5) * 0.03
        moments = middle + shutter * ((np.arange(20_000) + 0.5) / 20_000 - 0.5)
        light = 1.0 + 0.3 * np.cos(2 * np.pi * (100.0 * moments + 0.2))
        assert factor == pytest.approx(light.mean(), abs=1e-5)


def test_exposures_of_whole_periods_see_nothing() -> None:
    seen = flicker_factor(100, depth=0.5, frequency=100.0, shutter=0.010, readout=0.03, phase=0.1)
    np.testing.assert_allclose(seen, 1.0, atol=1e-6)


def test_a_global_shutter_has_no_bands_and_a_rolling_one_three_of_them() -> None:
    still = flicker_factor(300, depth=0.2, frequency=100.0, shutter=0.001, readout=0.0, phase=0.4)
    assert np.ptp(still) == 0
    bands = flicker_factor(300, depth=0.2, frequency=100.0, shutter=0.001, readout=0.03, phase=0.4)[:, 0, 0]
    spectrum = np.abs(np.fft.rfft(bands - bands.mean()))
    assert spectrum.argmax() == 3
