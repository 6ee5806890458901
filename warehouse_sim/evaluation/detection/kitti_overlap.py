"""The rows of a KITTI label or result file as columns, and how much their boxes have in common."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from warehouse_sim.dataset.formats.kitti.reader import DONT_CARE, KittiLabel
from warehouse_sim.geometry.boxes import box_areas, box_coverage, box_ious

_EDGES = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))


def rectangle_corners(rectangles: Float[np.ndarray, "n 5"]) -> Float[np.ndarray, "n 4 2"]:
    """Return the corners of rectangles in the order in which the first axis turns into the second.

    Args:
        rectangles: Centre (2), length, width, and the angle (rad) from the first axis to the length, in each row.
    """
    angle = rectangles[:, 4]
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * rectangles[:, 2, None]
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=-1) * rectangles[:, 3, None]
    return np.stack([rectangles[:, :2] + a * along + b * across for a, b in _EDGES], axis=1)


def shared_areas(a: Float[np.ndarray, "n 5"], b: Float[np.ndarray, "m 5"]) -> Float[np.ndarray, "n m"]:
    """Return the areas that turned rectangles (``rectangle_corners``) have in common."""
    corners_a, corners_b = rectangle_corners(a), rectangle_corners(b)
    reach = np.hypot(a[:, 2], a[:, 3])[:, None] / 2.0 + np.hypot(b[:, 2], b[:, 3]) / 2.0
    near = np.linalg.norm(a[:, None, :2] - b[None, :, :2], axis=-1) < reach
    shared = np.zeros(near.shape)
    for row, column in np.argwhere(near):
        shared[row, column] = _area(_cut(corners_a[row], corners_b[column]))
    return shared


def _cut(polygon: Float[np.ndarray, "k 2"], by: Float[np.ndarray, "4 2"]) -> Float[np.ndarray, "k 2"]:
    """Return the part of a convex polygon inside a rectangle, side by side (Sutherland and Hodgman, CACM 1974)."""
    for start, end in zip(by, np.roll(by, -1, axis=0), strict=True):
        if len(polygon) == 0:
            break
        side = end - start
        inside = side[0] * (polygon[:, 1] - start[1]) - side[1] * (polygon[:, 0] - start[0])
        after, inside_after = np.roll(polygon, -1, axis=0), np.roll(inside, -1)
        kept = []
        for here, there, depth, depth_there in zip(polygon, after, inside, inside_after, strict=True):
            if depth >= 0.0:
                kept.append(here)
            if (depth >= 0.0) != (depth_there >= 0.0):
                kept.append(here + (there - here) * (depth / (depth - depth_there)))
        polygon = np.array(kept).reshape(-1, 2)
    return polygon


def _area(polygon: Float[np.ndarray, "k 2"]) -> float:
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@dataclass(frozen=True, eq=False)
class KittiObjects:
    """Columns of equal length n, one row an object; units and frames are KITTI's."""

    type: Shaped[np.ndarray, " n"]
    truncated: Float[np.ndarray, " n"]
    occluded: Int[np.ndarray, " n"]
    alpha: Float[np.ndarray, " n"]
    """Rotation seen along the viewing ray (rad)."""
    box_xyxy: Float[np.ndarray, "n 4"]
    size_hwl: Float[np.ndarray, "n 3"]
    location: Float[np.ndarray, "n 3"]
    """Centre of the bottom face, camera frame (m)."""
    rotation_y: Float[np.ndarray, " n"]
    score: Float[np.ndarray, " n"]

    @classmethod
    def of(cls, labels: Sequence[KittiLabel], scores: Sequence[float] = ()) -> "KittiObjects":
        """Turn rows into columns; without scores, all are 1."""
        count = len(labels)
        return cls(
            type=np.array([label.type for label in labels], dtype=np.str_),
            truncated=np.array([label.truncated for label in labels], dtype=float),
            occluded=np.array([label.occluded for label in labels], dtype=int),
            alpha=np.array([label.alpha for label in labels], dtype=float),
            box_xyxy=np.array([label.box_xyxy for label in labels], dtype=float).reshape(-1, 4),
            size_hwl=np.array([label.size_hwl for label in labels], dtype=float).reshape(-1, 3),
            location=np.array([label.location for label in labels], dtype=float).reshape(-1, 3),
            rotation_y=np.array([label.rotation_y for label in labels], dtype=float),
            score=np.array(scores, dtype=float) if scores else np.ones(count),
        )

    def __len__(self) -> int:
        return len(self.type)

    def only(self, rows: Bool[np.ndarray, " n"]) -> "KittiObjects":
        """Return the rows where ``rows`` is true."""
        return KittiObjects(**{item.name: getattr(self, item.name)[rows] for item in fields(self)})

    @property
    def is_dont_care(self) -> Bool[np.ndarray, " n"]:
        """Which only mark a region of the image."""
        return np.asarray(self.type == DONT_CARE)

    @property
    def footprints(self) -> Float[np.ndarray, "n 5"]:
        """Rectangles on the ground: x and z of the centre, length, width, angle from x to z."""
        length, width = self.size_hwl[:, 2], self.size_hwl[:, 1]
        return np.column_stack([self.location[:, 0], self.location[:, 2], length, width, -self.rotation_y])


def overlaps(view: str, a: KittiObjects, b: KittiObjects) -> Float[np.ndarray, "n m"]:
    """Return the intersection over union of boxes in the "image", on the "ground" or in "space"."""
    if view == "image":
        return box_ious(a.box_xyxy, b.box_xyxy)
    shared, size_a, size_b = _shared(view, a, b)
    union = size_a[:, None] + size_b - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def fraction_in(view: str, a: KittiObjects, b: KittiObjects) -> Float[np.ndarray, "n m"]:
    """Return the fraction of each box of ``a`` that lies in a box of ``b``; off the image "DontCare" holds nothing."""
    if view == "image" and (box_areas(a.box_xyxy) > 0).any():
        return box_coverage(a.box_xyxy, b.box_xyxy)
    return np.zeros((len(a), len(b)))


def _shared(
    view: str, a: KittiObjects, b: KittiObjects
) -> tuple[Float[np.ndarray, "n m"], Float[np.ndarray, " n"], Float[np.ndarray, " m"]]:
    shared = shared_areas(a.footprints, b.footprints)
    size_a, size_b = (np.prod(item.size_hwl[:, 1:], axis=1) for item in (a, b))
    if view == "space":
        bottom_a, bottom_b = a.location[:, 1, None], b.location[:, 1]
        top_a, top_b = bottom_a - a.size_hwl[:, :1], bottom_b - b.size_hwl[:, 0]
        shared = shared * np.maximum(np.minimum(bottom_a, bottom_b) - np.maximum(top_a, top_b), 0.0)
        size_a, size_b = size_a * a.size_hwl[:, 0], size_b * b.size_hwl[:, 0]
    return shared, size_a, size_b
