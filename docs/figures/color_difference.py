"""How different two images look: CIEDE2000.

Formulas and test data: Sharma, Wu & Dalal 2005, "The CIEDE2000 color-difference formula: implementation notes,
supplementary test data, and mathematical observations". sRGB to CIELAB by IEC 61966-2-1 and CIE 15, white point D65.
"""

import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.color import XYZ_FROM_SRGB, linear_from_srgb

_FAR = 25.0**7


def lab_from_srgb(codes: UInt8[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 3"]:
    """Return L*, a*, b* of sRGB codes (0-255)."""
    t = linear_from_srgb(codes / 255.0) @ XYZ_FROM_SRGB.T / XYZ_FROM_SRGB.sum(axis=1)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def ciede2000(first: Float[np.ndarray, "*n 3"], second: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n"]:
    """Return the difference of pairs of CIELAB colours; 1 is just noticeable side by side."""
    (L1, a1, b1), (L2, a2, b2) = np.moveaxis(first, -1, 0), np.moveaxis(second, -1, 0)
    mean_chroma = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    stretch = 1.5 - 0.5 * np.sqrt(mean_chroma**7 / (mean_chroma**7 + _FAR))
    C1, C2 = np.hypot(a1 * stretch, b1), np.hypot(a2 * stretch, b2)
    h1, h2 = (np.degrees(np.arctan2(b, a * stretch)) % 360 for a, b in ((a1, b1), (a2, b2)))
    turn = np.where(C1 * C2 == 0, 0.0, (h2 - h1 + 180) % 360 - 180)
    # A turn of exactly 180 degrees counts as positive.
    turn = np.where((turn == -180) & (h2 > h1), 180.0, turn)
    dL, dC, dH = L2 - L1, C2 - C1, 2 * np.sqrt(C1 * C2) * np.sin(np.radians(turn / 2))
    L, C = (L1 + L2) / 2, (C1 + C2) / 2
    far_apart = np.abs(h1 - h2) > 180
    h = (h1 + h2 + np.where(far_apart, np.where(h1 + h2 < 360, 360, -360), 0)) / 2
    h = np.where(C1 * C2 == 0, h1 + h2, h)
    cosines = ((-0.17, 1, -30), (0.24, 2, 0), (0.32, 3, 6), (-0.20, 4, -63))
    T = 1 + sum(weight * np.cos(np.radians(times * h + offset)) for weight, times, offset in cosines)
    S_L = 1 + 0.015 * (L - 50) ** 2 / np.sqrt(20 + (L - 50) ** 2)
    S_C, S_H = 1 + 0.045 * C, 1 + 0.015 * C * T
    blue = 60 * np.exp(-(((h - 275) / 25) ** 2))
    R_T = -2 * np.sqrt(C**7 / (C**7 + _FAR)) * np.sin(np.radians(blue))
    light, chroma, hue = dL / S_L, dC / S_C, dH / S_H
    return np.sqrt(light**2 + chroma**2 + hue**2 + R_T * chroma * hue)
