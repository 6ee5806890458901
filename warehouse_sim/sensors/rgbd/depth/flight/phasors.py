"""Sums of modulated light: what a time-of-flight pixel reads where more than one path ends in it."""

import cv2
import numpy as np
from jaxtyping import Float32

Image = Float32[np.ndarray, "h w"]


def added(light: Image, ranges: Image, turn: float) -> tuple[Image, Image]:
    """Return real and imaginary part of light that went a way.

    Args:
        light: Its strength.
        ranges: Half the length of the way there and back (m).
        turn: Phase per range (rad/m).
    """
    real, imaginary = cv2.polarToCart(light, np.float32(turn) * ranges)
    return real, imaginary


def gathered(image: Image, spot_px: float) -> Image:
    """Return the sum over the spot that a pixel gathers light from, a Gaussian of ``spot_px`` (px); 0 = the pixel."""
    if spot_px == 0:
        return image
    size = 2 * int(np.ceil(2.0 * spot_px)) + 1
    kernel = cv2.getGaussianKernel(size, spot_px, cv2.CV_32F)
    blurred: Image = cv2.sepFilter2D(image, cv2.CV_32F, kernel, kernel)
    return blurred


def scattered(real: Image, imaginary: Image, fraction: float) -> tuple[np.float32, np.float32]:
    """Return what a lens and sensor scatter over the whole image: a fraction of the mean of its light.

    The spread of real lenses is wide and flat enough that one constant corrects most of it (Mure-Dubois & Huegli 2007,
    "Real-time scattering compensation for time-of-flight camera", use a few very broad Gaussians).
    """
    return np.float32(fraction * float(real.mean())), np.float32(fraction * float(imaginary.mean()))


def read_off(real: Image, imaginary: Image, ranges: Image, turn: float) -> Image:
    """Return by how much the phase of a sum differs from that of ``ranges`` (m), by the shorter way round."""
    off = cv2.phase(real, imaginary)
    off -= np.float32(turn) * ranges
    full = np.float32(2.0 * np.pi)
    off -= full * np.rint(off / full)
    return off / np.float32(turn)
