"""What is as high as a pallet above the floor is taken for one."""

from collections.abc import Sequence

import cv2
import numpy as np

from stranger_warehouse.floor import heights, points_of
from warehouse_sim.estimators.image import Detection, RgbdImage

_LOW, _HIGH = 0.03, 0.15
"""Heights (m) between which a pallet on the floor shows."""
_LEAST_PIXELS = 150
_WIDTHS = (0.5, 1.6)
"""Least and greatest extent across the view (m)."""


class LowThings:
    """Outlines connected pieces of what stands lower than a pallet is high; the camera must be level."""

    def detect(self, image: RgbdImage) -> Sequence[Detection]:
        """Return the pieces as detections of the model "epal1", the larger ones first."""
        points = points_of(image.depth, image.camera.K)
        height = heights(points)
        low = ((height > _LOW) & (height < _HIGH)).astype(np.uint8)
        count, pieces, stats, _ = cv2.connectedComponentsWithStats(low)
        found = []
        for piece in np.argsort(-stats[1:count, cv2.CC_STAT_AREA]) + 1:
            mask = pieces == piece
            if stats[piece, cv2.CC_STAT_AREA] < _LEAST_PIXELS:
                break
            across = np.ptp(np.percentile(points[mask][:, 0], [2, 98]))
            if _WIDTHS[0] < across < _WIDTHS[1]:
                found.append(Detection(mask, "epal1", score=float(min(1.0, mask.sum() / 5000.0))))
        return found
