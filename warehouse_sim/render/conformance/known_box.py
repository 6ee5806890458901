"""A box whose outline and depth are known in closed form, at places that many renderers are tested with."""

import numpy as np

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, make_transform, matrix_from_quat_wxyz, transform_points

OFF_CENTRE = PinholeCamera(320, 240, 310.0, 290.0, 121.3, 157.8)
"""Oblong pixels and a principal point far from the middle."""
SIZE = np.array([0.6, 0.4, 0.3])


def random_placements(count: int, margin: int) -> list[np.ndarray]:
    """Return poses of the box in the camera frame that keep it ``margin`` px inside the image of ``OFF_CENTRE``."""
    rng = np.random.default_rng(7)
    high = (OFF_CENTRE.width - 1 - margin, OFF_CENTRE.height - 1 - margin)
    found: list[np.ndarray] = []
    while len(found) < count:
        z = rng.uniform(1.5, 6.0)
        pixel = rng.uniform((0, 0), (OFF_CENTRE.width, OFF_CENTRE.height))
        ray = (pixel - (OFF_CENTRE.cx, OFF_CENTRE.cy)) / (OFF_CENTRE.fx, OFF_CENTRE.fy)
        T = make_transform(matrix_from_quat_wxyz(rng.normal(size=4)), np.array([*ray * z, z]))
        corners = OFF_CENTRE.project(transform_points(T, box_corners(SIZE)))
        if corners.min() > margin and (corners.max(axis=0) < high).all():
            found.append(T)
    return found


def polygon_centroid(points: np.ndarray) -> np.ndarray:
    """Return the centre of gravity of a polygon by its corners (n 2)."""
    x, y = points.T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y
    return np.array([((x + x2) * cross).sum(), ((y + y2) * cross).sum()]) / (3.0 * cross.sum())


def ray_box_depth(T_camera_object: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return z-depth (0 = missed) and normals where rays with z = 1 m meet a box, by the slab method in 64 bits."""
    T = invert(T_camera_object)
    directions = rays @ T[:3, :3].T
    a, b = (-SIZE / 2 - T[:3, 3]) / directions, (SIZE / 2 - T[:3, 3]) / directions
    enter, leave = np.minimum(a, b), np.maximum(a, b)
    axis = enter.argmax(axis=1)
    depth = np.where(enter.max(axis=1) < leave.min(axis=1), enter.max(axis=1), 0.0)
    sign = -np.sign(np.take_along_axis(directions, axis[:, None], axis=1))
    return depth, sign * np.eye(3)[axis] @ T_camera_object[:3, :3].T
