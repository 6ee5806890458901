"""Which way is down in a camera's frame: what an inertial unit, a levelled rig or the floor in sight can tell."""

from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform

GravitySource = Literal["rig", "floor", "none"]
"""Who says where down is: the rig's own place in the world, the floor in sight, or nobody."""
Direction = Float[np.ndarray, " 3"]


def down_of_camera(T_world_camera: Transform) -> Direction:
    """Return the unit vector of gravity in the frame of a camera whose place in a world with z up is known."""
    return -np.asarray(T_world_camera[2, :3], dtype=float)


def down_if_placed(T_world_camera: Transform) -> Direction | None:
    """Return gravity in the camera frame; None where a dataset says nothing of a world, which then is the camera's."""
    return None if np.array_equal(T_world_camera, np.eye(4)) else down_of_camera(T_world_camera)


def upright_frame(down: Direction) -> Float[np.ndarray, "3 3"]:
    """Return the rotation R_camera_upright of the frame that has z up and x where the camera looks, horizontally.

    A camera that looks straight down or up has no heading; then x is where its image's upper border is.

    Args:
        down: Unit vector of gravity (camera frame).
    """
    up = -np.asarray(down, dtype=float) / np.linalg.norm(down)
    ahead = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.999 else np.array([0.0, -1.0, 0.0])
    ahead = ahead - up * (ahead @ up)
    ahead /= np.linalg.norm(ahead)
    return np.stack([ahead, np.cross(up, ahead), up], axis=1)


def down_from_floor(
    camera: PinholeCamera,
    depth: Float32[np.ndarray, "h w"],
    rng: np.random.Generator,
    max_lean: float = 0.6,
    least_fraction: float = 0.05,
) -> Direction | None:
    """Return gravity as the floor in sight has it, or None where no floor is seen.

    The floor is the plane with most readings (RANSAC, Fischler and Bolles 1981) among those that nearly lie below the
    camera and that nothing but few readings lies under; its normal is fitted to them by least squares.

    Args:
        camera: Intrinsics.
        depth: Metres along the optical axis, 0 = no reading.
        rng: Source of randomness.
        max_lean: Largest angle (rad) between the image's downward direction and gravity.
        least_fraction: Least fraction of the readings that the floor must have.
    """
    v, u = np.nonzero(depth > 0)
    if len(u) < 100:
        return None
    chosen = rng.choice(len(u), min(len(u), 4000), replace=False)
    points = camera.rays_at(u[chosen], v[chosen]) * depth[v[chosen], u[chosen]][:, None].astype(float)
    best: np.ndarray | None = None
    for _ in range(200):
        a, b, c = points[rng.choice(len(points), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-6:
            continue
        normal = normal / length * np.sign(normal[1] or 1.0)
        height = float(normal @ a)
        if normal[1] < np.cos(max_lean) or height <= 0.05:
            continue
        above = height - points @ normal
        tolerance = 0.01 + 0.005 * points[:, 2]
        on = np.abs(above) <= tolerance
        if (above < -3.0 * tolerance).mean() < 0.02 and (best is None or on.sum() > best.sum()):
            best = on
    if best is None or best.mean() < least_fraction:
        return None
    return _plane_normal(points, best)


def _plane_normal(points: Float[np.ndarray, "n 3"], on: Bool[np.ndarray, " n"]) -> Direction:
    """Return the unit normal, the image's down side, of the plane near most of the points that are ``on`` it."""
    for _ in range(4):
        middle = points[on].mean(axis=0)
        normal = np.linalg.svd(points[on] - middle, full_matrices=False)[2][-1]
        away = np.abs((points - middle) @ normal)
        # 3 standard deviations by the median: what stands on the floor's far end would tilt it.
        on = on & (away <= 3.0 * 1.4826 * np.median(away[on]))
    return np.asarray(normal * np.sign(normal[1]))
