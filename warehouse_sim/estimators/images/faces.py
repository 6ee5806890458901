"""Boxes of the faces of pallets that a truck would enter, for networks that are to find these beside whole pallets."""

from collections.abc import Iterator, Mapping
from typing import Protocol

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.objects import FACES, ObjectInfo
from warehouse_sim.dataset.reader import ImageRecord, TargetRecord
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import transform_points

FACE = "pallet_face"
"""Class of the face of a pallet that is seen best."""
_PALLET = "pallet"
_LEAST_FACING = 0.1
"""Cosine between a face's normal and the way to the camera from which on it is a face."""
_AS_GOOD = 0.75
"""Cosine over that of the best face from which on a second one could be taken for it: within 8 deg of a diagonal."""
_MOSTLY_SEEN = 0.5
"""Visible fraction of the best face below which any other could be taken in its place."""
_NEAREST = 0.05
"""Depth (m) from which on all corners must lie."""


class MaskReader(Protocol):
    """What knows the objects of an image and their masks."""

    @property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """Objects by obj_id."""

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the mask of a target's visible pixels."""


def face_labels(reader: MaskReader, image: ImageRecord, box: Letterbox) -> Float[np.ndarray, "k 8"]:
    """Return the labels of faces as ``rows.LABEL`` names them, their obj_id that of the pallet below zero.

    The face that looks at the camera most is labelled. Another has a visible fraction of 0, so that nothing is taught
    of it, where it looks at the camera almost as much or where most of the best is hidden or outside of the image; else
    it is no face. A box holds what is seen of the face's rectangle,
    and its visible fraction is its area over that of the whole rectangle's box.

    Args:
        reader: Gives visible masks.
        image: One of its images.
        box: How the image is scaled.
    """
    found = [
        row
        for target in image.targets
        if target.pixels_visible > 0 and target.has_pose and target.info(reader.objects).class_name == _PALLET
        for row in _labels(reader, image, target, box)
    ]
    return np.array(found, dtype=float).reshape(-1, 8)


def _labels(
    reader: MaskReader, image: ImageRecord, target: TargetRecord, box: Letterbox
) -> Iterator[tuple[float, ...]]:
    sides = sorted(_facing(target, target.info(reader.objects)), key=lambda side: -side[0])
    mask: Bool[np.ndarray, "h w"] | None = None
    best = 0.0
    for place, (facing, corners) in enumerate(sides):
        least = _AS_GOOD * sides[0][0] if place and best >= _MOSTLY_SEEN else _LEAST_FACING
        if facing < max(_LEAST_FACING, least) or corners[:, 2].min() < _NEAREST:
            continue
        mask = reader.mask_visible(image, target.gt_index) if mask is None else mask
        outline = image.camera.project(corners)
        seen = mask_box_xyxy(mask & _inside(outline, mask.shape))
        if seen is None:
            continue
        # Inclusive corners of pixel centres become edges.
        left, top, right, bottom = seen[0], seen[1], seen[2] + 1, seen[3] + 1
        whole = np.prod(np.ptp(outline, axis=0))
        if not place:
            best = min(1.0, float((right - left) * (bottom - top) / max(whole, 1e-9)))
        edges = box.onto_canvas(np.array([[left, top, right, bottom]], dtype=float))[0]
        yield (*edges, -target.obj_id, 0.0 if place else best, bottom - top, target.gt_index)


def _facing(target: TargetRecord, info: ObjectInfo) -> Iterator[tuple[float, Float[np.ndarray, "4 3"]]]:
    """Yield how much each side that pockets open on looks at the camera (cosine), and its corners there (m)."""
    T, half = target.T_camera_object, np.asarray(info.size) / 2
    opened = {pocket.face for pocket in info.pockets} or set(FACES)
    for name, normal in FACES.items():
        if name not in opened:
            continue
        across = np.array([abs(normal[1]), abs(normal[0]), 0.0])
        ways = [sign * across + up * np.array([0.0, 0.0, 1.0]) for sign, up in ((-1, 1), (1, 1), (1, -1), (-1, -1))]
        corners = transform_points(T, np.array([(np.array(normal) + way) * half for way in ways]))
        centre = corners.mean(axis=0)
        yield -float(T[:3, :3] @ np.array(normal) @ centre) / max(float(np.linalg.norm(centre)), 1e-9), corners


def _inside(outline: Float[np.ndarray, "4 2"], shape: tuple[int, ...]) -> Bool[np.ndarray, "h w"]:
    """Return the pixels of a quadrilateral, its border included."""
    canvas = np.zeros(shape, dtype=np.uint8)
    # Far beyond the image its sides stay where they are; OpenCV takes no larger numbers.
    cv2.fillConvexPoly(canvas, np.rint(np.clip(outline, -16_000, 16_000)).astype(np.int32), 1)
    return canvas.astype(bool)
