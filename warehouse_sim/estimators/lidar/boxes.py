"""The points of a box of an image: every pixel with a reading, back in space."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, Int

from warehouse_sim.geometry.camera import PinholeCamera


class BoxPoints(NamedTuple):
    """Back-projected pixels."""

    points: Float[np.ndarray, "n 3"]
    """Camera frame (m)."""
    u: Int[np.ndarray, " n"]
    """Column of each point's pixel."""
    v: Int[np.ndarray, " n"]
    """Row of it."""


def box_points(
    camera: PinholeCamera, depth: Float32[np.ndarray, "h w"], box_xyxy: tuple[float, float, float, float]
) -> BoxPoints:
    """Return the points of a box, row by row.

    Args:
        camera: Of the image.
        depth: Metres along the optical axis, 0 = no reading.
        box_xyxy: Left, top, right and bottom (px); pixels whose centres lie within belong to it. It may leave the
            image.
    """
    left, top, right, bottom = box_xyxy
    first_u, first_v = max(int(np.ceil(left)), 0), max(int(np.ceil(top)), 0)
    after_u, after_v = min(int(np.floor(right)) + 1, camera.width), min(int(np.floor(bottom)) + 1, camera.height)
    part = depth[first_v : max(after_v, first_v), first_u : max(after_u, first_u)]
    v, u = np.nonzero(part > 0)
    z, u, v = part[v, u].astype(float), u + first_u, v + first_v
    return BoxPoints(camera.rays_at(u, v) * z[:, None], u, v)
