"""Colour: the sRGB curve both ways, luminance, CIE XYZ, and the colour of light by its temperature.

Linear values are linear light with the primaries and the white (D65) of sRGB, IEC 61966-2-1.
"""

import numpy as np
from jaxtyping import Float

XYZ_FROM_SRGB = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
"""Linear sRGB to CIE XYZ, with the digits of IEC 61966-2-1."""
SRGB_FROM_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
"""CIE XYZ to linear sRGB, with the digits of IEC 61966-2-1."""
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Fraction of each linear sRGB channel in luminance (Rec. 709)."""


def srgb_from_linear(linear: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the sRGB code (0-1) of linear light (0-1), in the same precision."""
    return np.where(linear > 0.0031308, 1.055 * np.power(linear, 1.0 / 2.4) - 0.055, 12.92 * linear)


def linear_from_srgb(code: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the linear light (0-1) of an sRGB code (0-1), in the same precision."""
    return np.where(code > 0.04045, ((code + 0.055) / 1.055) ** 2.4, code / 12.92)


def balanced_rgb(temperature: float, white_balance: float) -> tuple[float, float, float]:
    """Return the linear sRGB colour of unit luminance of a light, as a camera with a fixed white balance sees it.

    Args:
        temperature: Correlated colour temperature of the light (K), 1700-20000.
        white_balance: Colour temperature that the camera takes for white (K), 1700-20000.
    """
    # von Kries adaptation in linear sRGB: each channel is scaled so that the white balance's black body is white.
    color = planckian_rgb(temperature) / planckian_rgb(white_balance)
    red, green, blue = color / (LUMINANCE @ color)
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
    rgb = np.maximum(SRGB_FROM_XYZ @ np.array([x / y, 1.0, (1.0 - x - y) / y]), 1e-3)
    return rgb / (LUMINANCE @ rgb)
