"""What happens to light before it falls on the pixels: lens and housing spread it, and so does motion."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.pixel_rays import pixel_stretch, pixel_tangents

_WIDE, _NARROW = (1.0 / 20.0, 16), (1.0 / 120.0, 4)
"""Halo of the lens, and the one close about lamps and windows: standard deviation over the image's width, and edge (px)
of the blocks in which light is spread, as it has no finer detail there. No source: priors."""
_WIDE_FRACTION, _NARROW_FRACTION = 0.35, 0.25
"""Of the scattered light, what the halos get; the rest is even. No source: priors."""


def spread_points(linear: Float32[np.ndarray, "h w 3"], sigma_px: float) -> Float32[np.ndarray, "h w 3"]:
    """Return the image behind a Gaussian point spread of ``sigma_px``; its light is kept away from the border."""
    if sigma_px == 0:
        return linear
    reach = 2 * max(1, round(2.5 * sigma_px)) + 1
    return cv2.GaussianBlur(linear, (reach, reach), sigma_px, borderType=cv2.BORDER_REPLICATE)


def add_glare(linear: Float32[np.ndarray, "h w 3"], fraction: float) -> Float32[np.ndarray, "h w 3"]:
    """Return the image with ``fraction`` of its light scattered: evenly, and as two halos about what is bright.

    ISO 9358 calls the fraction veiling glare (index); photographic lenses have 1-5 %. Brightness clips only afterwards,
    so that a door in the sun veils what is before it. The sum of the light stays, but for the halos beyond the border.
    """
    if fraction == 0:
        return linear
    height, width = linear.shape[:2]
    wide, narrow = _halo(linear, *_WIDE), _halo(linear, *_NARROW)
    even = (1.0 - _WIDE_FRACTION - _NARROW_FRACTION) * wide.mean(axis=(0, 1))
    veil = (fraction * (_WIDE_FRACTION * wide + even)).astype(np.float32)
    veil = cv2.resize(veil, narrow.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    veil = cv2.addWeighted(veil, 1.0, narrow, fraction * _NARROW_FRACTION, 0.0)
    veil = cv2.resize(veil, (width, height), interpolation=cv2.INTER_LINEAR)
    return cv2.addWeighted(linear, 1.0 - fraction, veil, 1.0, 0.0)


def _halo(linear: Float32[np.ndarray, "h w 3"], spread: float, block: int) -> Float32[np.ndarray, "r c 3"]:
    """Return the light of blocks of ``block`` pixels, spread over ``spread`` of the width."""
    height, width = linear.shape[:2]
    size = (max(width // block, 1), max(height // block, 1))
    coarse = cv2.resize(linear, size, interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(coarse, (0, 0), max(spread * size[0], 0.5), borderType=cv2.BORDER_REFLECT)


@lru_cache(maxsize=8)
def vignetting_factor(camera: PinholeCamera, fraction: float) -> Float32[np.ndarray, "h w 1"]:
    """Return the light that reaches each pixel relative to the axis: cos^4 of the angle to it, softened."""
    if camera.distortion is None:
        x = (np.arange(camera.width) - camera.cx) / camera.fx
        y = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    else:
        x, y, _ = np.moveaxis(camera.rays(), -1, 0)
    cosine4 = (1.0 + x * x + y * y) ** -2.0
    factor = (1.0 - fraction * (1.0 - cosine4)).astype(np.float32)[..., None]
    factor.setflags(write=False)
    return factor


_LEAST_PX = 0.5
"""Blur that cannot be seen."""
_SPACING_PX = 1.0
"""From one place to the next on the longest way of a block."""
_MOST_TAPS = 13
_BLOCK_PX = 128
"""Edge of the blocks of pixels that look at as many places as their own longest way requires."""


def blur_by_motion(
    linear: Float32[np.ndarray, "h w 3"],
    depth: Float32[np.ndarray, "h w"],
    camera: PinholeCamera,
    motion: Motion,
    shutter: float,
    readout: float = 0.0,
) -> Float32[np.ndarray, "h w 3"]:
    """Return the mean of the light along each pixel's way through the image, a few places per way.

    A rolling shutter takes rows one after the other: each looks at the way's part of its own time. Each pixel follows
    its own surface; what passes before it at the edge of a nearer thing is left out. Ways are long where things are
    near: each block of pixels looks at as many places as its own longest way requires.

    Args:
        linear: Light at the middle of the exposure of the middle row.
        depth: True z-depth (m), 0 = infinitely far.
        camera: Intrinsics.
        motion: Of the camera.
        shutter: For how long the shutter is open (s).
        readout: From the first row's exposure to the last one's (s); 0 = all at once.
    """
    if not motion.velocity.any() and not motion.rotation.any():
        return linear
    rate = image_flow(depth, camera, motion)
    u, v = rate[..., 0], rate[..., 1]
    square = u * u + v * v
    if square.max() * max(shutter, readout / 2) ** 2 < _LEAST_PX**2:
        return linear
    time = ((np.arange(camera.height, dtype=np.float32) + 0.5) / camera.height - 0.5) * np.float32(readout)
    blurred = np.empty_like(linear)
    for top in range(0, camera.height, _BLOCK_PX):
        for left in range(0, camera.width, _BLOCK_PX):
            block = slice(top, top + _BLOCK_PX), slice(left, left + _BLOCK_PX)
            fastest = float(np.sqrt(square[block].max()))
            # What a row sees at its time was at the middle row's time where the way came from.
            late = time[block[0], None, None] * -rate[block] if readout * fastest > _LEAST_PX else None
            flow = rate[block] * np.float32(shutter)
            blurred[block] = _mean_along(linear, flow, late, (left, top), shutter * fastest)
    return blurred


def _mean_along(
    linear: Float32[np.ndarray, "h w 3"],
    flow: Float32[np.ndarray, "b c 2"],
    late: Float32[np.ndarray, "b c 2"] | None,
    corner: tuple[int, int],
    longest: float,
) -> Float32[np.ndarray, "b c 3"]:
    """Return the mean of the light along the ways of a block of pixels; ``flow`` is used up.

    Args:
        linear: The whole image.
        flow: Of the block's pixels while the shutter is open (px).
        late: From each pixel to the middle of its way (px); None = it is the middle.
        corner: Column and row of the block's first pixel.
        longest: Length of its longest way (px).
    """
    height, width = flow.shape[:2]
    left, top = corner
    if longest < _LEAST_PX and late is None:
        return linear[top : top + height, left : left + width]
    taps = int(np.clip(np.ceil(longest / _SPACING_PX) + 1, 3, _MOST_TAPS)) if longest >= _LEAST_PX else 1
    flow *= np.float32(1.0 / taps)
    place = flow * np.float32((1 - taps) / 2)
    place[..., 0] += np.arange(left, left + width, dtype=np.float32)
    place[..., 1] += np.arange(top, top + height, dtype=np.float32)[:, None]
    if late is not None:
        place += late
    total = np.zeros((height, width, 3), np.float32)
    for _ in range(taps):
        coarse, fine = cv2.convertMaps(place, None, cv2.CV_16SC2)  # 1/32 px, and faster than an exact map
        total += cv2.remap(linear, coarse, fine, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        place += flow
    total *= np.float32(1.0 / taps)
    return total


def image_flow(
    depth: Float32[np.ndarray, "h w"], camera: PinholeCamera, motion: Motion
) -> Float32[np.ndarray, "h w 2"]:
    """Return how fast each pixel's surface, at rest in the world, moves in the image (px/s).

    Longuet-Higgins & Prazdny 1980, "The interpretation of a moving retinal image".

    Args:
        depth: True z-depth (m), 0 = infinitely far.
        camera: Intrinsics.
        motion: Of the camera.
    """
    x, y = pixel_tangents(camera)
    vx, vy, vz = (np.float32(value) for value in motion.velocity)
    wx, wy, wz = (np.float32(value) for value in motion.rotation)
    near = np.divide(np.float32(1.0), depth, out=np.zeros_like(depth), where=depth > 0)
    turned = wx * y - wy * x
    flow = np.empty((*depth.shape, 2), np.float32)
    flow[..., 0] = (x * vz - vx) * near - (wy - wz * y) + x * turned
    flow[..., 1] = (y * vz - vy) * near - (wz * x - wx) + y * turned
    if camera.distortion is not None:
        flow = np.einsum("hwij,hwj->hwi", pixel_stretch(camera), flow)
    flow[..., 0] *= np.float32(camera.fx)
    flow[..., 1] *= np.float32(camera.fy)
    return flow
