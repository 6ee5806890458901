import numpy as np

from warehouse_sim.scene.lighting.colour import LUMINANCE, lamp_colour, planckian_rgb


def test_black_body_colours() -> None:
    # The daylight white of sRGB (D65) is close to the black body of 6500 K.
    np.testing.assert_allclose(planckian_rgb(6504.0), 1.0, atol=0.06)
    for temperature in (1800.0, 2222.0, 3000.0, 4000.0, 4001.0, 9000.0):
        np.testing.assert_allclose(LUMINANCE @ planckian_rgb(temperature), 1.0)
    red_over_blue = [planckian_rgb(t)[0] / planckian_rgb(t)[2] for t in (2000.0, 3000.0, 4000.0, 5000.0, 8000.0)]
    assert red_over_blue == sorted(red_over_blue, reverse=True)
    for joint in (2222.0, 4000.0):
        np.testing.assert_allclose(planckian_rgb(joint), planckian_rgb(joint + 0.01), atol=2e-3)


def test_chromaticities_are_those_of_the_planckian_locus() -> None:
    """x, y of a black body at 2856 K (CIE standard illuminant A) and 4000 K, by integrating Planck's law."""
    to_xyz = np.linalg.inv([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    for temperature, expected in ((2856.0, (0.4476, 0.4074)), (4000.0, (0.3805, 0.3768))):
        xyz = to_xyz @ planckian_rgb(temperature)
        np.testing.assert_allclose(xyz[:2] / xyz.sum(), expected, atol=2e-3)


def test_a_warm_lamp_is_warm_and_white_balance_makes_it_white() -> None:
    red, _, blue = lamp_colour(3000.0, 6500.0)
    assert red > 1.2 > 0.6 > blue
    np.testing.assert_allclose(lamp_colour(3000.0, 3000.0), 1.0)
    np.testing.assert_allclose(LUMINANCE @ lamp_colour(2700.0, 4700.0), 1.0)
