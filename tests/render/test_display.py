import numpy as np
import pytest

from warehouse_sim.render.display import inverse_tone_map, to_display, tone_map


def test_the_ends_and_the_middle_are_where_the_fit_puts_them() -> None:
    assert tone_map(np.array([0.0, 0.18, 1.0, 1e9])) == pytest.approx([0.0, 0.2669, 0.8038, 1.0], abs=1e-4)


def test_display_values_grow_with_light_in_every_channel_and_never_wrap() -> None:
    ramp = np.linspace(-0.5, 50.0, 3000).reshape(50, 20, 3)
    shown = to_display(ramp)
    assert shown.dtype == np.uint8
    assert shown.shape == ramp.shape
    assert (np.diff(shown.reshape(-1).astype(int)) >= 0).all()
    assert shown.min() == 0
    assert shown.max() == 255


def test_the_inverse_of_the_filmic_curve() -> None:
    x = np.geomspace(1e-4, 7.0, 200)
    assert inverse_tone_map(tone_map(x)) == pytest.approx(x, rel=1e-6)
    assert inverse_tone_map(np.zeros(1)) == pytest.approx(0.0)
