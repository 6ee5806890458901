"""The smallest oriented rectangle around a mask whose corners lie in the image."""

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.boxes import mask_box_xyxy

_OUTSIDE = 1e-6
"""How far (px) a corner may leave the image by rounding."""


def oriented_box(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "4 2"]:
    """Return the corners (x, y), in pixels from the image's outer corner, around the set pixels of a mask, whole.

    One side of the smallest rectangle lies along the convex hull (Freeman and Shapira 1975). Rectangles that leave the
    image are passed over, since tools reject their corners; the upright one never does.

    Args:
        mask: Not empty.
    """
    hull = _hull(mask)
    sides = np.roll(hull, -1, axis=0) - hull
    angles = np.concatenate([[0.0], np.arctan2(sides[:, 1], sides[:, 0])])
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    (a0, a1), (b0, b1) = ((np.min(hull @ axis.T, axis=0), np.max(hull @ axis.T, axis=0)) for axis in (along, across))
    ends = np.stack([np.stack(pair, axis=1) for pair in ((a0, b0), (a1, b0), (a1, b1), (a0, b1))], axis=1)
    corners = ends[..., :1] * along[:, None] + ends[..., 1:] * across[:, None]
    size_wh = np.array([mask.shape[1], mask.shape[0]])
    inside = ((corners >= -_OUTSIDE) & (corners <= size_wh + _OUTSIDE)).all(axis=(1, 2))
    areas = np.where(inside, (a1 - a0) * (b1 - b0), np.inf)
    best: Float[np.ndarray, "4 2"] = np.clip(corners[int(np.argmin(areas))], 0.0, size_wh)
    return best


def _hull(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "n 2"]:
    """Return the convex hull of the outer corners of the set pixels."""
    box = mask_box_xyxy(mask)
    assert box is not None
    left, top, right, bottom = box
    window = mask[top : bottom + 1, left : right + 1]
    rows = np.flatnonzero(window.any(axis=1))
    first, last = window[rows].argmax(axis=1), window.shape[1] - window[rows, ::-1].argmax(axis=1)
    ends = [(x + left, y + top + edge) for x in (first, last) for y, edge in ((rows, 0), (rows, 1))]
    points = np.concatenate([np.stack(item, axis=1) for item in ends]).astype(np.int32)
    hull: Float[np.ndarray, "n 2"] = cv2.convexHull(points)[:, 0].astype(float)
    return hull
