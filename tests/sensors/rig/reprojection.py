"""How well LiDAR points and a depth image agree under a calibration."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points

_SAME_SURFACE = 0.15
"""Farther from the image's surface (m), one of the two sees something that the other does not."""


@dataclass(frozen=True)
class Residuals:
    """Of points on the depth image."""

    count: int
    median_m: float
    """Median distance along the optical axis between a point and the surface in the image."""
    shift_px: float
    """By how much the points are to be moved in the image to fit it best."""


def residuals(points: np.ndarray, T_camera_lidar: np.ndarray, depth: np.ndarray, camera: PinholeCamera) -> Residuals:
    """Compare points with the image between its pixels: 1 / z is linear in u and v on a plane (perspective).

    Where the four pixels around a point are of one surface, the shift that brings points and image together follows
    from all residuals and the slopes of the image by least squares (Lucas & Kanade 1981).
    """
    seen = transform_points(T_camera_lidar, points.astype(float))
    seen = seen[seen[:, 2] > 0.3]
    u, v = camera.project(seen).T
    inside = (u > 0) & (u < camera.width - 1) & (v > 0) & (v < camera.height - 1)
    u, v, z = u[inside], v[inside], seen[inside, 2]
    column, row = np.floor(u).astype(int), np.floor(v).astype(int)
    corners = np.stack([depth[row + j, column + i] for j in (0, 1) for i in (0, 1)]).astype(float)
    near, far = corners.min(axis=0), corners.max(axis=0)
    whole = (near > 0) & (far - near < 0.02 * far)
    a, b, c, d = 1.0 / corners[:, whole]
    x, y, z = (u - column)[whole], (v - row)[whole], z[whole]
    inverse = (1 - y) * ((1 - x) * a + x * b) + y * ((1 - x) * c + x * d)
    error = z - 1.0 / inverse
    same = np.abs(error) < _SAME_SURFACE
    slope_u, slope_v = (1 - y) * (b - a) + y * (d - c), (1 - x) * (c - a) + x * (d - b)
    slopes = -np.stack([slope_u, slope_v], axis=1) / inverse[:, None] ** 2
    # A few points past edges would outweigh the many on surfaces: large residuals count less and less (Cauchy).
    usual = max(float(np.median(np.abs(error[same]))), 1e-4)
    weight = 1.0 / (1.0 + (error / (3.0 * usual)) ** 2)
    weighted = slopes[same] * weight[same, None]
    shift = np.linalg.solve(weighted.T @ slopes[same], weighted.T @ error[same])
    return Residuals(int(same.sum()), float(np.median(np.abs(error[same]))), float(np.linalg.norm(shift)))
