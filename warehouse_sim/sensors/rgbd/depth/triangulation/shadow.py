"""What only one eye of a triangulating camera sees: the shadow of its baseline."""

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int

from warehouse_sim.geometry.camera import PinholeCamera


def baseline_shadow(
    disparity: Float32[np.ndarray, "h w"], camera: PinholeCamera | None = None
) -> Bool[np.ndarray, "h w"]:
    """Return the pixels that a second eye, to the right or left by the baseline, does not see.

    All pixels are projected into the second image, where the largest disparity hides what is behind it: beside the left
    edge of near things a band is hidden that is f b (1 / z_near - 1 / z_far) wide, at the left border one of f b / z.

    Args:
        disparity: f b / z in pixels of this image, negative for an eye to the left; 0 where there is nothing.
        camera: Of the image; needed where a lens distorts it, and the second eye's image in the same way.
    """
    height, width = disparity.shape
    rows: Int[np.ndarray, "h columns"] = np.arange(height, dtype=np.int32)[:, None]
    gap = 1
    if camera is None or camera.distortion is None:
        columns = np.rint(np.arange(width, dtype=np.float32) - disparity).astype(np.int32)
    else:
        rays = camera.rays() - np.stack([disparity / camera.fx, *np.zeros((2, height, width))], axis=-1)
        gap, (columns, rows) = 3, np.moveaxis(np.rint(camera.project(rays)).astype(np.int32), -1, 0)
    outside = (columns < 0) | (columns >= width) | (rows < 0) | (rows >= height)
    place = np.clip(columns, 0, width - 1) + width * np.clip(rows, 0, height - 1)
    nearest, size = np.zeros(height * width, np.float32), cv2.absdiff(disparity, 0.0)
    np.maximum.at(nearest, place.ravel(), (size * ~outside).ravel())
    # Surfaces that the second eye sees larger leave single columns open.
    closed = cv2.morphologyEx(nearest.reshape(height, width), cv2.MORPH_CLOSE, np.ones((gap, 3), np.uint8))
    return outside | (closed.ravel()[place] > size + np.float32(1.0))
