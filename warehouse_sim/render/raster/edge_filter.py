"""Softening of the stairs that edges make on a pixel grid; colour only, ids and depth are never blended."""

import cv2
import numpy as np
from jaxtyping import Bool, UInt8


def smooth_edges(rgba: UInt8[np.ndarray, "h w 4"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return the colours, filtered by a 3 x 3 binomial kernel at pixels that touch another face.

    Args:
        rgba: Colours, and in the fourth channel a number that differs between neighbouring faces of the scene.
    """
    rgb = cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB)
    soft = cv2.GaussianBlur(rgb, (3, 3), 0)
    cv2.copyTo(soft, face_borders(rgba[..., 3]).view(np.uint8), rgb)
    return rgb


def face_borders(face: UInt8[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Return the pixels with a neighbour above, below, left or right that shows another face."""
    across, down = face[:, 1:] != face[:, :-1], face[1:] != face[:-1]
    borders = np.zeros(face.shape, bool)
    borders[:, 1:] |= across
    borders[:, :-1] |= across
    borders[1:] |= down
    borders[:-1] |= down
    return borders
