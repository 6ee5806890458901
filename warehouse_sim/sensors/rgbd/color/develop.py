"""What the camera does to an image before it stores it: noise and grain away, edges up, JPEG."""

import cv2
import numpy as np
from jaxtyping import Int16, UInt8

_FINE = (5, 5)
"""Pixels of the Gaussian that tells fine detail from what is under it."""
_COLOR = (7, 7)
"""The same for colour differences, which eyes and JPEG see coarsely."""


def develop(
    rgb: UInt8[np.ndarray, "h w 3"], *, noise: float, denoise: float, sharpen: float
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image with its finest detail cored and amplified, as the processors of cameras do.

    Brightness is split into its mean over a pixel or two and what differs from it. Of the difference what is below the
    noise is removed (soft threshold, Donoho 1995) and the rest amplified (unsharp masking): grain between one and a few
    pixels stays, as blotches do in real images, and a median filter does not remove it. Colour differences are
    smoothed.

    Args:
        rgb: Codes.
        noise: Standard deviation of noise in them.
        denoise: Threshold over ``noise``; 0 leaves all.
        sharpen: Fraction of the remaining detail that is added once more.
    """
    if denoise == 0 and sharpen == 0:
        return rgb
    brightness, red, blue = cv2.split(cv2.cvtColor(rgb, cv2.COLOR_RGB2YCrCb))
    base = cv2.GaussianBlur(brightness, _FINE, 0)
    detail = cv2.addWeighted(brightness, 1.0, base, -1.0, 128.0)  # saturates: finer detail than half of all codes
    kept = cv2.LUT(detail, _detail_table(denoise * noise, 1.0 + sharpen))
    if denoise > 0:
        red, blue = (cv2.GaussianBlur(color, _COLOR, 0) for color in (red, blue))
    return cv2.cvtColor(cv2.merge([cv2.add(base, kept, dtype=cv2.CV_8U), red, blue]), cv2.COLOR_YCrCb2RGB)


def compressed(rgb: UInt8[np.ndarray, "h w 3"], quality: int) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image after JPEG."""
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])
    return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def _detail_table(threshold: float, amplification: float) -> Int16[np.ndarray, " 256"]:
    """Return what remains of differences of -128 to 127."""
    difference = np.arange(-128, 128)
    kept = np.sign(difference) * np.maximum(np.abs(difference) - threshold, 0.0)
    return np.rint(amplification * kept).astype(np.int16)
