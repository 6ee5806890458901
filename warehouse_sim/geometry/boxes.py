"""Axis-aligned image boxes (``box_xyxy``, inclusive pixel corners) and boxes in space."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.pose import Transform, transform_points


@dataclass(frozen=True, eq=False)
class OrientedBox:
    """A box in some parent frame: its centre frame and its full edge lengths (m)."""

    T_parent_box: Transform
    size: Float[np.ndarray, " 3"]

    def placed(self, T_frame_parent: Transform) -> "OrientedBox":
        """Return the same box in the frame that its parent stands in."""
        return OrientedBox(T_frame_parent @ self.T_parent_box, self.size)

    def corners(self) -> Float[np.ndarray, "8 3"]:
        """Return the eight corners in the parent frame (m)."""
        return transform_points(self.T_parent_box, box_corners(self.size))


def box_corners(size: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "8 3"]:
    """Return the corners of a centred box, x slowest and z fastest, minus before plus."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    return signs * np.asarray(size) / 2.0


def box_edges() -> list[tuple[int, int]]:
    """Return the twelve edges of ``box_corners`` as index pairs."""
    return [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]


def along_edges(corners: Float[np.ndarray, "8 3"], count: int = 9) -> Float[np.ndarray, "n 3"]:
    """Return ``count`` points on each edge of a box, ends included, from its ``box_corners`` in any frame."""
    a, b = np.array(box_edges()).T
    fraction = np.linspace(0.0, 1.0, count)[:, None, None]
    return (corners[a] + fraction * (corners[b] - corners[a])).reshape(-1, 3)


def mask_box_xyxy(mask: Bool[np.ndarray, "h w"]) -> tuple[int, int, int, int] | None:
    """Return (left, top, right, bottom) of the set pixels, all inclusive, or None for an empty mask."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if columns.size == 0:
        return None
    return int(columns[0]), int(rows[0]), int(columns[-1]), int(rows[-1])


def box_ious(a: Float[np.ndarray, "n 4"], b: Float[np.ndarray, "m 4"]) -> Float[np.ndarray, "n m"]:
    """Return the intersection over union of boxes given by the coordinates of their edges."""
    shared = _shared(a, b)
    union = box_areas(a)[:, None] + box_areas(b) - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def box_coverage(a: Float[np.ndarray, "n 4"], b: Float[np.ndarray, "m 4"]) -> Float[np.ndarray, "n m"]:
    """Return the fraction of each box of ``a`` that lies in a box of ``b``: COCO's overlap with crowds."""
    shared, area = _shared(a, b), np.broadcast_to(box_areas(a)[:, None], (len(a), len(b)))
    return np.divide(shared, area, out=np.zeros_like(shared), where=area > 0)


def mask_intersections(a: Bool[np.ndarray, "n h w"], b: Bool[np.ndarray, "m h w"]) -> Float[np.ndarray, "n m"]:
    """Return the pixels that masks have in common."""
    # No mask at all does not say how many pixels it would have.
    pixels = int(np.prod(a.shape[1:]))
    flat = a.reshape(len(a), pixels).astype(np.float32) @ b.reshape(len(b), pixels).astype(np.float32).T
    return flat.astype(float)


def box_areas(boxes: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, " n"]:
    """Return the areas of boxes; 0 of what is turned inside out."""
    area: Float[np.ndarray, " n"] = np.maximum(boxes[:, 2:] - boxes[:, :2], 0.0).prod(axis=1)
    return area


def _shared(a: Float[np.ndarray, "n 4"], b: Float[np.ndarray, "m 4"]) -> Float[np.ndarray, "n m"]:
    # Coordinate by coordinate: short axes at the end are slow.
    width = np.minimum(a[:, 2, None], b[:, 2]) - np.maximum(a[:, 0, None], b[:, 0])
    height = np.minimum(a[:, 3, None], b[:, 3]) - np.maximum(a[:, 1, None], b[:, 1])
    shared: Float[np.ndarray, "n m"] = np.maximum(width, 0.0) * np.maximum(height, 0.0)
    return shared
