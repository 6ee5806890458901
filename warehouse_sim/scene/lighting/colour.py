"""The colour of lamps as a camera with a fixed white balance sees it."""

import numpy as np
from jaxtyping import Float

_SRGB_FROM_XYZ = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)  # IEC 61966-2-1
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Share of each linear sRGB channel in luminance (Rec. 709)."""


def lamp_colour(temperature: float, white_balance: float) -> tuple[float, float, float]:
    """Return the linear sRGB colour of unit luminance of a lamp.

    Args:
        temperature: Correlated colour temperature of the lamp (K), 1700-20000.
        white_balance: Colour temperature that the camera takes for white (K), 1700-20000.
    """
    # von Kries adaptation in linear sRGB: each channel is scaled so that the white balance's black body is white.
    colour = planckian_rgb(temperature) / planckian_rgb(white_balance)
    red, green, blue = colour / (LUMINANCE @ colour)
    return float(red), float(green), float(blue)


def planckian_rgb(temperature: float) -> Float[np.ndarray, " 3"]:
    """Return the linear sRGB colour of unit luminance of a black body at ``temperature`` (K), 1700-20000.

    Chromaticity by the cubic fits of Kang et al., J. Korean Phys. Soc. 41 (2002) 865.
    """
    t = 1000.0 / temperature
    if temperature <= 4000.0:
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
    else:
        x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
    if temperature <= 2222.0:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif temperature <= 4000.0:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    rgb = np.maximum(_SRGB_FROM_XYZ @ np.array([x / y, 1.0, (1.0 - x - y) / y]), 1e-3)
    return rgb / (LUMINANCE @ rgb)
