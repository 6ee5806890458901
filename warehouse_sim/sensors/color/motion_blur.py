"""What moves in a picture while the shutter is open, because the camera moves."""

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.shot import Motion

_LEAST_PX = 0.5
"""Blur that cannot be seen."""
_SPACING_PX = 1.5
"""From one place to the next on the longest way."""
_MOST_TAPS = 9


def blur_by_motion(
    linear: Float32[np.ndarray, "h w 3"],
    depth: Float32[np.ndarray, "h w"],
    camera: PinholeCamera,
    motion: Motion,
    shutter: float,
) -> Float32[np.ndarray, "h w 3"]:
    """Return the mean of the light along each pixel's way through the picture, a few places per way.

    Each pixel follows its own surface; what passes before it at the edge of a nearer thing is left out.

    Args:
        linear: Light at the middle of the exposure.
        depth: True z-depth (m), 0 = infinitely far.
        camera: Intrinsics.
        motion: Of the camera.
        shutter: For how long the shutter is open (s).
    """
    if not motion.velocity.any() and not motion.rotation.any():
        return linear
    flow = shutter * image_flow(depth, camera, motion)
    longest = float(np.sqrt(np.square(flow).sum(axis=-1).max()))
    if longest < _LEAST_PX:
        return linear
    taps = int(np.clip(np.ceil(longest / _SPACING_PX) + 1, 3, _MOST_TAPS))
    height, width = depth.shape
    flow *= np.float32(1.0 / taps)
    place = flow * np.float32((1 - taps) / 2)
    place[..., 0] += np.arange(width, dtype=np.float32)
    place[..., 1] += np.arange(height, dtype=np.float32)[:, None]
    total = np.zeros_like(linear)
    for _ in range(taps):
        coarse, fine = cv2.convertMaps(place, None, cv2.CV_16SC2)  # 1/32 px, and half the time of an exact map
        total += cv2.remap(linear, coarse, fine, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        place += flow
    return total * np.float32(1.0 / taps)


def image_flow(
    depth: Float32[np.ndarray, "h w"], camera: PinholeCamera, motion: Motion
) -> Float32[np.ndarray, "h w 2"]:
    """Return how fast each pixel's surface, at rest in the world, moves in the picture (px/s).

    Longuet-Higgins & Prazdny 1980, "The interpretation of a moving retinal image".

    Args:
        depth: True z-depth (m), 0 = infinitely far.
        camera: Intrinsics.
        motion: Of the camera.
    """
    x = (np.arange(camera.width, dtype=np.float32) - np.float32(camera.cx)) / np.float32(camera.fx)
    y = ((np.arange(camera.height, dtype=np.float32) - np.float32(camera.cy)) / np.float32(camera.fy))[:, None]
    vx, vy, vz = (np.float32(value) for value in motion.velocity)
    wx, wy, wz = (np.float32(value) for value in motion.rotation)
    near = np.divide(np.float32(1.0), depth, out=np.zeros_like(depth), where=depth > 0)
    turned = wx * y - wy * x
    flow = np.empty((*depth.shape, 2), np.float32)
    flow[..., 0] = np.float32(camera.fx) * ((x * vz - vx) * near - (wy - wz * y) + x * turned)
    flow[..., 1] = np.float32(camera.fy) * ((y * vz - vy) * near - (wz * x - wx) + y * turned)
    return flow
