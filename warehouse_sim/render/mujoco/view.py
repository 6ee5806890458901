"""The camera of a view, and images of a MuJoCo scene through it."""

import mujoco
import numpy as np
from jaxtyping import Float32, Int64, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform

NEAR, FAR = 0.05, 1000.0
"""Distances of the clipping planes (m); with reversed depth in floats the far one costs no precision."""


def aim(scene: mujoco.MjvScene, camera: PinholeCamera, T_world_camera: Transform) -> None:
    """Look through ``camera``: its frustum is set edge by edge, so that the principal point may lie anywhere.

    OpenGL samples a pixel at its middle, half a pixel right of and below its first edge: the edges of the image are at
    u = -0.5 and u = width - 0.5.
    """
    left, right = (np.array([-0.5, camera.width - 0.5]) - camera.cx) * NEAR / camera.fx
    top, bottom = (camera.cy - np.array([-0.5, camera.height - 0.5])) * NEAR / camera.fy
    for eye in scene.camera:  # two for stereo; a single image is taken between them
        eye.pos, eye.forward, eye.up = T_world_camera[:3, 3], T_world_camera[:3, 2], -T_world_camera[:3, 1]
        eye.frustum_center, eye.frustum_width = (left + right) / 2, (right - left) / 2
        eye.frustum_bottom, eye.frustum_top = bottom, top
        eye.frustum_near, eye.frustum_far = NEAR, FAR


def render_color(
    scene: mujoco.MjvScene, context: mujoco.MjrContext, size: tuple[int, int]
) -> UInt8[np.ndarray, "h w 3"]:
    """Render the lit image of ``size`` (width, height), antialiased."""
    rect = mujoco.MjrRect(0, 0, *size)
    pixels = np.empty((size[1], size[0], 3), np.uint8)
    mujoco.mjr_render(rect, scene, context)
    mujoco.mjr_readPixels(pixels, None, rect, context)
    return np.ascontiguousarray(pixels[::-1])


def render_ids(
    scene: mujoco.MjvScene, context: mujoco.MjrContext, size: tuple[int, int]
) -> tuple[Int64[np.ndarray, "h w"], Float32[np.ndarray, "h w"]]:
    """Render the number of the geom that each pixel shows, -1 for none, and its depth (m), 0 for none.

    Both come from one pass in MuJoCo's segmentation mode, which has no antialiasing. In it the geom's number plus one
    is its colour, and depth runs from 1 at the near to 0 at the far plane:
    d = near (far - z) / (z (far - near)), as glFrustum after ``mjDEPTH_ZEROFAR`` gives it.
    """
    rect = mujoco.MjrRect(0, 0, *size)
    pixels, depth = np.empty((size[1], size[0], 3), np.uint8), np.empty((size[1], size[0]), np.float32)
    mujoco.mjr_render(rect, scene, context)
    mujoco.mjr_readPixels(pixels, depth, rect, context)
    code = pixels[::-1] @ np.array([1, 1 << 8, 1 << 16])
    metres = NEAR * FAR / (depth[::-1].astype(np.float64) * (FAR - NEAR) + NEAR)
    return code - 1, np.where(code > 0, metres, 0.0).astype(np.float32)


def set_numbering(scene: mujoco.MjvScene) -> None:
    """Make ``render_ids`` possible: geoms are rendered flat in the colour of their number."""
    scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = 1
    scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = 1
