"""The rows of a KITTI label or result file as columns, and how much their boxes have in common."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from warehouse_sim.dataset.formats.kitti.label import DONT_CARE, KittiLabel
from warehouse_sim.geometry.footprints import shared_areas
from warehouse_sim.geometry.overlap import box_areas, box_coverage, box_ious


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
