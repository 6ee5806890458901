"""Edges of depth: readings on the wrong side of a jump, fattened edges, and the shadow of the baseline."""

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int

from warehouse_sim.geometry.camera import PinholeCamera


def baseline_shadow(
    disparity: Float32[np.ndarray, "h w"], camera: PinholeCamera | None = None
) -> Bool[np.ndarray, "h w"]:
    """Return the pixels that a second eye, to the right or left by the baseline, does not see.

    All pixels are projected into the second image, where the largest disparity hides what is behind it: beside the left
    edge of near things a band is hidden that is f b (1 / z_near - 1 / z_far) wide, at the left border one of f b / z.

    Args:
        disparity: f b / z in pixels of this image, negative for an eye to the left; 0 where there is nothing.
        camera: Of the image; needed where a lens distorts it, and the second eye's image in the same way.
    """
    height, width = disparity.shape
    rows: Int[np.ndarray, "h columns"] = np.arange(height, dtype=np.int32)[:, None]
    gap = 1
    if camera is None or camera.distortion is None:
        columns = np.rint(np.arange(width, dtype=np.float32) - disparity).astype(np.int32)
    else:
        rays = camera.rays() - np.stack([disparity / camera.fx, *np.zeros((2, height, width))], axis=-1)
        gap, (columns, rows) = 3, np.moveaxis(np.rint(camera.project(rays)).astype(np.int32), -1, 0)
    outside = (columns < 0) | (columns >= width) | (rows < 0) | (rows >= height)
    place = np.clip(columns, 0, width - 1) + width * np.clip(rows, 0, height - 1)
    nearest, size = np.zeros(height * width, np.float32), cv2.absdiff(disparity, 0.0)
    np.maximum.at(nearest, place.ravel(), (size * ~outside).ravel())
    # Surfaces that the second eye sees larger leave single columns open.
    closed = cv2.morphologyEx(nearest.reshape(height, width), cv2.MORPH_CLOSE, np.ones((gap, 3), np.uint8))
    return outside | (closed.ravel()[place] > size + np.float32(1.0))


Image = Float32[np.ndarray, "h w"]


def fattened(
    disparity: Image, reach_px: float, swing: Image, least_step_px: float
) -> tuple[Image, Bool[np.ndarray, "h w"]]:
    """Return disparities where near things have grown over what is behind them, and where they have.

    A window on the far side of a step holds some of the near side, whose texture wins as far as ``reach_px``. Slopes
    are left alone.

    Args:
        disparity: True disparity (px of any image), 0 = nothing there.
        reach_px: By how much things grow on either side (image pixels).
        swing: Noise of variance 1 that makes the border ragged; by a quarter of the reach.
        least_step_px: Least step of disparity that counts (in its unit).
    """
    near, far = (_grown(disparity, fraction * reach_px) for fraction in (0.75, 1.25))
    wide: Image = cv2.copyTo(far, (swing > 0).view(np.uint8), near)
    grew = cv2.subtract(wide, disparity) > np.float32(least_step_px)
    return cv2.copyTo(wide, grew.view(np.uint8), disparity.copy()), grew


def widened(shadow: Bool[np.ndarray, "h w"], reach_px: float, to_left: bool, swing: Image) -> Bool[np.ndarray, "h w"]:
    """Return a shadow that reaches further to one side.

    Args:
        shadow: What a second eye does not see.
        reach_px: By how much, on average (px).
        to_left: Whether to the left: the side of the near thing's shadow that is away from the thing.
        swing: Noise of variance 1; decides between the whole pixels below and above the reach.
    """
    least = int(reach_px)
    found = [_moved(shadow, step, to_left) for step in range(1, least + 2)]
    for item in found[:-1]:
        shadow = shadow | item
    # Of Gaussian noise, about a fraction p is below 1.6 (p - 0.5) / (p (1 - p) + 0.4).
    fraction = reach_px - least
    return shadow | (found[-1] & (swing < np.float32(1.6 * (fraction - 0.5) / (fraction * (1 - fraction) + 0.4))))


def _moved(image: Bool[np.ndarray, "h w"], step: int, to_left: bool) -> Bool[np.ndarray, "h w"]:
    moved = np.zeros_like(image)
    if to_left:
        moved[:, :-step] = image[:, step:]
    else:
        moved[:, step:] = image[:, :-step]
    return moved


def _grown(disparity: Image, reach_px: float) -> Image:
    size = 2 * max(round(reach_px), 0) + 1
    return cv2.dilate(disparity, np.ones((size, size), np.uint8))


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
