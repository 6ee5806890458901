"""From a pinhole camera to what the rasteriser needs: window coordinates and bounds."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import box_corners, box_edges
from warehouse_sim.geometry.camera import PinholeCamera

NEAR = 0.05
"""Distance of the near plane (m); there is no far plane."""


WINDOW_PX = 16384
"""Edge of the window that images are rendered through; what leaves the image is cut off pixel by pixel.

Were the window as large as the image, triangles would be clipped at its border, and the new corners rounded to the
rasteriser's grid: the same object would then cover other pixels in the image than in its amodal mask.
"""

MAX_IMAGE_PX = 4096
"""Longest edge of an image; three of them, as amodal masks need, stay within the window."""


def image_origin(size: tuple[int, int]) -> tuple[int, int]:
    """Return the window position of the first pixel of a target of ``size`` (width, height)."""
    return (WINDOW_PX - size[0]) // 2, (WINDOW_PX - size[1]) // 2


def window_viewport(size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the viewport (x, y, width, height) that shows the middle of the window in a target of ``size``."""
    left, bottom = image_origin(size)
    return -left, -bottom, WINDOW_PX, WINDOW_PX


def window_intrinsics(camera: PinholeCamera) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy in target coordinates, where the first pixel reaches from 0 to 1.

    Row 0 is rendered at the bottom of the target, so that what is read back starts with the top row.
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
    low, high = box_bounds(camera, rotation, translation, centre, half_size)
    if not np.isfinite(low).any():
        return None
    return (*low.min(axis=0), *high.max(axis=0))


def box_bounds(
    camera: PinholeCamera,
    rotation: Float[np.ndarray, "n 3 3"],
    translation: Float[np.ndarray, "n 3"],
    centre: Float[np.ndarray, "n 3"],
    half_size: Float[np.ndarray, "n 3"],
) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n 2"]]:
    """Return for each box alone its least and greatest (u, v) in pixels; infinity and its negative if it lies behind.

    The arguments are those of ``projected_bounds``.
    """
    local = centre[:, None] + box_corners(np.full(3, 2.0)) * half_size[:, None]
    corners = local @ np.swapaxes(rotation, 1, 2) + translation[:, None]
    ahead = corners[..., 2] >= NEAR
    pixels = camera.project(np.where(ahead[..., None], corners, 1.0))
    low = np.where(ahead[..., None], pixels, np.inf).min(axis=1)
    high = np.where(ahead[..., None], pixels, -np.inf).max(axis=1)
    cut = np.flatnonzero(ahead.any(axis=1) & ~ahead.all(axis=1))
    a, b = np.moveaxis(corners[cut][:, np.array(box_edges())], 2, 0)
    row, edge = np.nonzero((a[..., 2] < NEAR) != (b[..., 2] < NEAR))
    a, b = a[row, edge], b[row, edge]
    crossing = camera.project(a + (b - a) * ((NEAR - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None])
    np.minimum.at(low, cut[row], crossing)
    np.maximum.at(high, cut[row], crossing)
    return low, high
