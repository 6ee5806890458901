"""The depth image that a sweep gives where no camera measured one."""

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.geometry.camera import PinholeCamera

_NEAREST = 0.1
"""Depth (m) below which a point is not before the camera."""


def sweep_depth(camera: PinholeCamera, points: Float[np.ndarray, "n 3"]) -> Float32[np.ndarray, "h w"]:
    """Return depth along the optical axis (m) at the pixels that points fall on, the nearest of each; 0 elsewhere.

    Args:
        camera: Of the image.
        points: In the camera frame (m).
    """
    ahead = points[points[:, 2] > _NEAREST]
    depth = np.full((camera.height, camera.width), np.inf, dtype=np.float32)
    low_x, high_x, low_y, high_y = camera.tangent_bounds()
    x, y = ahead[:, 0] / ahead[:, 2], ahead[:, 1] / ahead[:, 2]
    # A lens is defined where the image is: beyond, its polynomial may lead back into it.
    seen = ahead[(x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y)]
    at = np.rint(camera.project(seen)).astype(int)
    inside = ((at >= 0) & (at < [camera.width, camera.height])).all(axis=1)
    np.minimum.at(depth, (at[inside, 1], at[inside, 0]), seen[inside, 2].astype(np.float32))
    return np.where(np.isinf(depth), np.float32(0.0), depth)
