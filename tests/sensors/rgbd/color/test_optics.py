import numpy as np
import pytest
from scipy.special import ndtr

from warehouse_sim.sensors.rgbd.color.optics import add_glare, spread_points


def test_an_edge_becomes_the_integral_of_the_point_spread() -> None:
    edge = np.zeros((40, 60, 3), np.float32)
    edge[:, 30:] = 1.0
    profile = spread_points(edge, 1.2)[20, :, 0]
    # A pixel's taps are samples of the Gaussian, so its step lies between two pixels: at 29.5.
    np.testing.assert_allclose(profile, ndtr((np.arange(60) - 29.5) / 1.2), atol=0.012)
    assert spread_points(edge, 0.0) is edge


def test_a_door_in_the_sun_veils_what_is_far_from_it_by_its_share_of_the_mean() -> None:
    """7 times saturation on a tenth of the image: 2/5 of 4 % of 0.7 fall on the far corner, more next to the door."""
    light = np.zeros((320, 640, 3), np.float32)
    light[:, :64] = 7.0
    veiled = add_glare(light, 0.04)
    assert veiled[160, 639, 0] == pytest.approx(0.4 * 0.04 * 0.7, rel=0.02)
    assert veiled[160, 70, 0] > 3 * veiled[160, 639, 0]
    assert veiled.mean() == pytest.approx(light.mean(), rel=0.01)  # scattered, not made


def test_a_lamp_has_a_narrow_halo_in_the_wide_one() -> None:
    light = np.full((480, 840, 3), 0.02, np.float32)
    light[232:248, 400:440] = 7.0
    row = add_glare(light, 0.02)[240, 444:560:4, 0]
    assert np.all(np.diff(row) < 1e-5)
    # Some pixels beside the lamp stand out by more than a fifth, a sigma of the wide halo away by little.
    assert row[0] > 1.2 * row[9]
    assert row[9] < 1.5 * 0.02
    assert add_glare(light, 0.0) is light
