"""Where depth jumps, and readings that fall on the wrong side of a jump."""

import cv2
import numpy as np
from jaxtyping import Bool, Float32

Depth = Float32[np.ndarray, "h w"]


def inverse_depth(depth: Depth) -> Depth:
    """Return 1 / depth (1/m), 0 where there is nothing: linear over the image of a plane."""
    return np.divide(np.float32(1.0), depth, out=np.zeros_like(depth), where=depth > 0)


def near_jumps(depth: Depth, reach_px: float, fraction: float = 0.01) -> Bool[np.ndarray, "h w"]:
    """Return the pixels from which a jump or kink of depth is within reach.

    Args:
        depth: True z-depth (m).
        reach_px: How far away (px).
        fraction: Least deviation from a plane that counts, as a fraction of depth.
    """
    inverse = inverse_depth(depth)
    bend = np.abs(cv2.Laplacian(inverse, cv2.CV_32F, borderType=cv2.BORDER_REPLICATE))
    jumps = (bend > np.float32(fraction) * inverse).astype(np.uint8)
    size = 2 * int(np.ceil(reach_px)) + 1
    return cv2.dilate(jumps, np.ones((size, size), np.uint8)).astype(bool)


def jitter_jumps(depth: Depth, sigma_px: Depth, rng: np.random.Generator) -> Depth:
    """Return depth as read at places that are shifted by Gaussian noise along u and v (Handa et al. 2014).

    Only pixels near jumps are shifted. On planes a shift is an axial error, and the axial noise of published fits was
    measured on planes, so that it is part of it already.

    Args:
        depth: True z-depth (m).
        sigma_px: Standard deviation of the shift at each pixel (px).
        rng: Source of the shifts.
    """
    height, width = depth.shape
    v, u = np.nonzero(near_jumps(depth, 2.0 * float(sigma_px.max())))
    shift = rng.standard_normal((2, len(u)), dtype=np.float32) * sigma_px[v, u]
    from_u = np.clip(np.rint(u + shift[0]).astype(np.int64), 0, width - 1)
    from_v = np.clip(np.rint(v + shift[1]).astype(np.int64), 0, height - 1)
    shifted = depth.copy()
    shifted[v, u] = depth[from_v, from_u]
    return shifted
