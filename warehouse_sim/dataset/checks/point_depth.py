"""Draw the amodal mask and depth of a surface from points on it: rough, but as fast for a scan as for a box."""

import cv2
import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points

_NEAR = 0.01
_CLOSED = np.ones((3, 3), np.uint8)


def point_depth(
    points: Float[np.ndarray, "n 3"], T_camera_object: Transform, camera: PinholeCamera
) -> Float[np.ndarray, "h w"] | None:
    """Return z-depth (m) of a surface, infinity where it is not; None if part of it is behind the camera.

    Each point fills its pixel, the nearest one wins, and gaps of a pixel are closed: right to about a pixel.

    Args:
        points: Spread over the surface (m, object frame), several for each pixel.
        T_camera_object: Its pose.
        camera: Pixel centres at integers.
    """
    placed = transform_points(T_camera_object, points)
    if placed[:, 2].min() < _NEAR:
        return None
    u, v = np.rint(camera.project(placed)).T
    inside = (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
    order = np.argsort(-placed[inside, 2])
    depth = np.full((camera.height, camera.width), np.inf, np.float32)
    # Of several numbers for one place the last one stays.
    depth[v[inside][order].astype(int), u[inside][order].astype(int)] = placed[inside, 2][order]
    amodal_mask = cv2.morphologyEx(np.isfinite(depth).astype(np.uint8), cv2.MORPH_CLOSE, _CLOSED) > 0
    # What lies behind shows through gaps between the points in front.
    nearest = cv2.erode(np.where(np.isfinite(depth), depth, np.float32(1e9)), _CLOSED, borderValue=1e9)
    return np.where(amodal_mask, nearest, np.inf).astype(np.float64)
