"""From a pinhole camera to what the rasteriser needs: window coordinates and bounds."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import box_corners, box_edges
from warehouse_sim.geometry.camera import PinholeCamera

NEAR = 0.05
"""Distance of the near plane (m); there is no far plane."""


WINDOW_PX = 16384
"""Edge of the window that images are drawn through; what leaves the image is cut off pixel by pixel.

Were the window as large as the image, triangles would be clipped at its border, and the new corners rounded to the
rasteriser's grid: the same object would then cover other pixels in the image than in its silhouette.
"""

MAX_IMAGE_PX = 4096
"""Longest edge of an image; three of them, as silhouettes need, stay within the window."""


def image_origin(size: tuple[int, int]) -> tuple[int, int]:
    """Return the window position of the first pixel of a target of ``size`` (width, height)."""
    return (WINDOW_PX - size[0]) // 2, (WINDOW_PX - size[1]) // 2


def window_viewport(size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the viewport (x, y, width, height) that shows the middle of the window in a target of ``size``."""
    left, bottom = image_origin(size)
    return -left, -bottom, WINDOW_PX, WINDOW_PX


def window_intrinsics(camera: PinholeCamera) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy in target coordinates, where the first pixel reaches from 0 to 1.

    Row 0 is drawn at the bottom of the target, so that what is read back starts with the top row.
    """
    return camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5


def projected_bounds(
    camera: PinholeCamera,
    rotation: Float[np.ndarray, "n 3 3"],
    translation: Float[np.ndarray, "n 3"],
    centre: Float[np.ndarray, "n 3"],
    half_size: Float[np.ndarray, "n 3"],
) -> tuple[float, float, float, float] | None:
    """Return left, top, right, bottom (pixels) of boxes cut at the near plane, or None if all lie behind it.

    Args:
        camera: Intrinsics.
        rotation: From each box's frame to the camera's.
        translation: Origin of each box's frame in the camera frame (m).
        centre: Centre of each box in its own frame (m).
        half_size: Half edge lengths of each box (m).
    """
    local = centre[:, None] + box_corners(np.full(3, 2.0)) * half_size[:, None]
    corners = np.einsum("nij,nkj->nki", rotation, local) + translation[:, None]
    a, b = np.moveaxis(corners[:, np.array(box_edges())], 2, 0)
    crosses = (a[..., 2] < NEAR) != (b[..., 2] < NEAR)
    a, b = a[crosses], b[crosses]
    cut = a + (b - a) * ((NEAR - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None]
    points = np.concatenate([corners[corners[..., 2] >= NEAR], cut])
    if len(points) == 0:
        return None
    pixels = camera.project(points)
    return (*pixels.min(axis=0), *pixels.max(axis=0))
