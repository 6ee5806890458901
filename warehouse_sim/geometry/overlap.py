"""How much boxes and masks have in common."""

import numpy as np
from jaxtyping import Bool, Float


def box_ious(a: Float[np.ndarray, "n 4"], b: Float[np.ndarray, "m 4"]) -> Float[np.ndarray, "n m"]:
    """Return the intersection over union of boxes given by the coordinates of their edges."""
    shared = _shared(a, b)
    union = box_areas(a)[:, None] + box_areas(b) - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def box_coverage(a: Float[np.ndarray, "n 4"], b: Float[np.ndarray, "m 4"]) -> Float[np.ndarray, "n m"]:
    """Return the fraction of each box of ``a`` that lies in a box of ``b``: COCO's overlap with crowds."""
    shared, area = _shared(a, b), np.broadcast_to(box_areas(a)[:, None], (len(a), len(b)))
    return np.divide(shared, area, out=np.zeros_like(shared), where=area > 0)


def mask_ious(a: Bool[np.ndarray, "n h w"], b: Bool[np.ndarray, "m h w"]) -> Float[np.ndarray, "n m"]:
    """Return the intersection over union of masks."""
    shared = mask_intersections(a, b)
    union = a.sum(axis=(1, 2))[:, None] + b.sum(axis=(1, 2)) - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def mask_intersections(a: Bool[np.ndarray, "n h w"], b: Bool[np.ndarray, "m h w"]) -> Float[np.ndarray, "n m"]:
    """Return the pixels that masks have in common."""
    flat = a.reshape(len(a), -1).astype(np.float32) @ b.reshape(len(b), -1).astype(np.float32).T
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
