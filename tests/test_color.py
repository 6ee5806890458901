"""Colour transforms against published numbers and OpenCV's own matrices."""

from fractions import Fraction

import cv2
import numpy as np
import pytest

from warehouse_sim.color import (
    LUMINANCE,
    SRGB_FROM_XYZ,
    XYZ_FROM_SRGB,
    balanced_rgb,
    linear_from_srgb,
    planckian_rgb,
    srgb_from_linear,
)

# Byte of sRGB -> linear value, as tables of the standard print it.
PUBLISHED = {0: 0.0, 1: 0.000304, 10: 0.003035, 11: 0.003347, 64: 0.051269, 128: 0.215861, 188: 0.502886, 255: 1.0}


@pytest.mark.parametrize(("byte", "linear"), PUBLISHED.items())
def test_the_srgb_curve_has_its_published_values_both_ways(byte: int, linear: float) -> None:
    assert linear_from_srgb(np.array(byte / 255.0)) == pytest.approx(linear, abs=5.1e-7)
    # Half of the last printed digit, by the steepest slope.
    assert srgb_from_linear(np.array(linear)) == pytest.approx(byte / 255.0, abs=12.92 * 5e-7)


def test_the_srgb_curve_solves_the_standards_equation_in_whole_powers() -> None:
    """2.4 is 12 / 5: the fifth power of what is linear is the twelfth of the code's, in exact fractions."""
    codes = [Fraction(byte, 255) for byte in range(256)]
    linear = [Fraction(value) for value in linear_from_srgb(np.arange(256) / 255.0).tolist()]
    assert [code for code in codes if code <= Fraction("0.04045")] == codes[:11]
    for code, value in zip(codes[:11], linear[:11], strict=True):
        assert float(value * Fraction("12.92")) == pytest.approx(float(code), rel=1e-14)
    for code, value in zip(codes[11:], linear[11:], strict=True):
        shifted = (code + Fraction("0.055")) / Fraction("1.055")
        assert float(value**5 / shifted**12) == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_there_and_back_changes_no_byte_and_no_type(dtype: type) -> None:
    code = (np.arange(256) / 255.0).astype(dtype)
    there = linear_from_srgb(code)
    back = srgb_from_linear(there)
    assert there.dtype == back.dtype == dtype
    assert (np.diff(there) > 0.0).all()
    np.testing.assert_array_equal(np.rint(255.0 * back), np.arange(256))


def test_luminance_and_xyz_are_opencvs() -> None:
    """For the same primaries and a white point with more digits."""
    axes = np.eye(3, dtype=np.float32)[None]
    columns = cv2.cvtColor(axes, cv2.COLOR_RGB2XYZ)[0].T
    np.testing.assert_allclose(XYZ_FROM_SRGB, columns, atol=4e-4)
    np.testing.assert_allclose(SRGB_FROM_XYZ, cv2.cvtColor(axes, cv2.COLOR_XYZ2RGB)[0].T, atol=4e-4)
    np.testing.assert_allclose(LUMINANCE, columns[1], atol=1e-4)
    assert LUMINANCE.sum() == pytest.approx(1.0)


def test_black_body_colours() -> None:
    # The daylight white of sRGB (D65) is close to the black body of 6500 K.
    np.testing.assert_allclose(planckian_rgb(6504.0), 1.0, atol=0.06)
    for temperature in (1800.0, 2222.0, 3000.0, 4000.0, 4001.0, 9000.0):
        np.testing.assert_allclose(LUMINANCE @ planckian_rgb(temperature), 1.0)
    red_over_blue = [planckian_rgb(t)[0] / planckian_rgb(t)[2] for t in (2000.0, 3000.0, 4000.0, 5000.0, 8000.0)]
    assert red_over_blue == sorted(red_over_blue, reverse=True)
    for joint in (2222.0, 4000.0):
        np.testing.assert_allclose(planckian_rgb(joint), planckian_rgb(joint + 0.01), atol=2e-3)


@pytest.mark.parametrize("temperature", [2000.0, 2856.0, 4000.0, 6500.0, 10000.0])
def test_chromaticities_are_those_of_plancks_law(temperature: float) -> None:
    """Integrated with the fits of the CIE 1931 observer by Wyman, Sloan and Shirley 2013, good to about 0.005."""
    nm = np.arange(380.0, 781.0)
    power = nm**-5 / np.expm1(1.438777e7 / (nm * temperature))

    def lobe(height: float, peak: float, below: float, above: float) -> np.ndarray:
        return height * np.exp(-0.5 * ((nm - peak) * np.where(nm < peak, below, above)) ** 2)

    x = lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(-0.065, 501.1, 0.0490, 0.0382)
    y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322)
    z = lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)
    expected = np.array([power @ x, power @ y, power @ z])
    xyz = np.linalg.inv(SRGB_FROM_XYZ) @ planckian_rgb(temperature)
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), expected[:2] / expected.sum(), atol=5e-3)


def test_a_warm_light_is_warm_and_white_balance_makes_it_white() -> None:
    red, _, blue = balanced_rgb(3000.0, 6500.0)
    assert red > 1.2 > 0.6 > blue
    np.testing.assert_allclose(balanced_rgb(3000.0, 3000.0), 1.0)
