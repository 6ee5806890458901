"""Statistics of images against images whose statistics are known."""

import numpy as np
import pytest

from docs.figures.picture_statistics import edge_density, spectrum_slope, statistics


@pytest.mark.parametrize("slope", [1.0, 2.4, 3.5])
def test_the_slope_of_a_power_law_is_its_own(slope: float) -> None:
    rng = np.random.default_rng(0)
    # Twice as large as what is looked at, so that it does not repeat at the borders.
    axis = np.fft.fftfreq(1024)
    frequency = np.maximum(np.hypot(axis[:, None], axis), 1e-4)
    spectrum = np.fft.fft2(rng.standard_normal((1024, 1024))) * frequency ** (-slope / 2)
    image = np.real(np.fft.ifft2(spectrum))[:480, :480]
    assert spectrum_slope(image) == pytest.approx(slope, abs=0.12)


def test_a_square_has_the_edges_of_its_outline() -> None:
    grey = np.zeros((100, 100), dtype=np.uint8)
    grey[30:70, 30:70] = 255
    assert edge_density(grey) == pytest.approx(4 * 40 / 100**2, abs=0.002)
    assert edge_density(np.full((50, 50), 90, dtype=np.uint8)) == 0.0


def test_colours_of_an_even_image_are_its_own() -> None:
    rng = np.random.default_rng(1)
    red = np.zeros((360, 640, 3), dtype=np.uint8)
    red[..., 0], red[..., 1:] = 200, 100
    found = statistics([red + rng.integers(0, 2, red.shape, dtype=np.uint8)])
    assert found["saturation"] == pytest.approx(0.5, abs=0.01)
    assert found["median_a"] > 30
    # L* of sRGB (200, 100, 100), by the formulas of CIE 1976 and IEC 61966-2-1.
    assert found["lightness"] == pytest.approx(54.4, abs=0.2)
    assert found["darker_than_35"] == 0.0
