"""Masks of scene_gt_coco.json as COCO's own tools read them."""

from typing import Any

import numpy as np
from jaxtyping import Bool
from pycocotools import mask as coco_mask

from warehouse_sim.errors import DatasetError


def decode_runs(segmentation: Any, shape: tuple[int, int], where: str) -> Bool[np.ndarray, "h w"]:
    """Return the mask of uncompressed run lengths, decoded by pycocotools.

    Args:
        segmentation: ``{"size": [h, w], "counts": [...]}``, column by column, zeros first.
        shape: Height and width of its image.
        where: File and image, for the message.

    Raises:
        DatasetError: Not run lengths that fill the image; pycocotools would take them without a word.
    """
    size, counts = (segmentation.get(key) if isinstance(segmentation, dict) else None for key in ("size", "counts"))
    if size != list(shape):
        raise DatasetError(f"{where}: a segmentation has the size {size!r}, its image {list(shape)} (h, w)")
    if not isinstance(counts, list) or not all(type(count) is int and count >= 0 for count in counts):
        raise DatasetError(f"{where}: counts of a segmentation must be a list of whole numbers >= 0")
    if sum(counts) != shape[0] * shape[1]:
        raise DatasetError(f"{where}: the counts of a segmentation fill {sum(counts)} of {shape[0] * shape[1]} pixels")
    decoded: Bool[np.ndarray, "h w"] = coco_mask.decode(coco_mask.frPyObjects(segmentation, *shape)).view(bool)
    return decoded
