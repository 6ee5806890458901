"""What one camera of a kind has of its own: errors of its calibration that no frame averages out."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.pixel_rays import pixel_tangents

_STREAM = 0x756E6974
"""Of all draws of units."""


@dataclass(frozen=True)
class StereoUnit:
    """Of one triangulating camera."""

    scale: float
    """By which all depths are too large, as a fraction."""
    bow: float
    """Disparity at the corners less that at the middle (px of the sensor), as the square of the distance grows."""
    tilt: float
    """Disparity at the right border less that at the left (px of the sensor)."""
    shift_uv: tuple[float, float]
    """By how much depth is registered beside colour (px of the image)."""

    @classmethod
    def draw(cls, unit: int, scale: float, bow_px: float, registration_px: float) -> "StereoUnit":
        """Return the camera of a number; numbers draw from a stream of their own.

        Args:
            unit: Its number.
            scale: Standard deviation of ``scale``.
            bow_px: That of ``bow`` and of ``tilt``.
            registration_px: That of each of ``shift_uv``.
        """
        sampled = np.random.default_rng([_STREAM, unit]).standard_normal(5)
        return cls(scale * sampled[0], bow_px * sampled[1], bow_px * sampled[2],
                   (registration_px * sampled[3], registration_px * sampled[4]))  # fmt: skip

    def offset(self, camera: PinholeCamera) -> Float32[np.ndarray, "h w"]:
        """Return the error of disparity at each pixel (px of the sensor), zero on average over the image."""
        x, y = pixel_tangents(camera)
        corner = np.float32(self.bow / max(float(np.square(x).max() + np.square(y).max()), 1e-9))
        across = corner * np.square(x) + np.float32(self.tilt / max(float(np.ptp(x)), 1e-9)) * x
        down = corner * np.square(y)
        return (across - across.mean()) + (down - down.mean())


def shifted(image: np.ndarray, shift_uv: tuple[float, float]) -> np.ndarray:
    """Return an image whose pixels have moved by whole pixels, its border repeated.

    Args:
        image: Of any kind.
        shift_uv: By how much (px), rounded.
    """
    right, down = (round(value) for value in shift_uv)
    if right == down == 0:
        return image
    height, width = image.shape[:2]
    moved = cv2.copyMakeBorder(image, max(down, 0), max(-down, 0), max(right, 0), max(-right, 0), cv2.BORDER_REPLICATE)
    return moved[max(-down, 0) :, max(-right, 0) :][:height, :width]
