"""Draw a mesh's depth without a graphics library: the referee for poses, masks and depth on disk."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, transform_points

_NEAR = 0.05


def mesh_depth(
    mesh: TriangleMesh, T_camera_object: Transform, camera: PinholeCamera
) -> Float[np.ndarray, "h w"] | None:
    """Return the z-depth (m) of a closed mesh at every pixel centre, infinity where it is not; None if it is too near.

    Each triangle covers the pixels inside its three edges; 1/z is linear over the image (Pineda 1988; perspective
    correction as in Blinn 1992).

    Args:
        mesh: Surface in the object frame (m).
        T_camera_object: Its pose.
        camera: Pixel centres at integers.
    """
    points = transform_points(T_camera_object, mesh.vertices)
    depth = np.full((camera.height, camera.width), np.inf)
    if points[:, 2].min() < _NEAR:
        return None
    uv, inverse_z = camera.project(points), 1.0 / points[:, 2]
    for face in mesh.faces:
        _draw_triangle(depth, uv[face], inverse_z[face])
    return depth


def _draw_triangle(
    depth: Float[np.ndarray, "h w"], uv: Float[np.ndarray, "3 2"], inverse_z: Float[np.ndarray, " 3"]
) -> None:
    (ax, ay), (bx, by), (cx, cy) = uv
    doubled_area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    # Counter-clockwise to the eye is a negative area where v points down; anything else is seen from behind.
    if doubled_area >= 0.0:
        return
    first = np.maximum(np.ceil(uv.min(axis=0)).astype(int), 0)
    last = np.minimum(np.floor(uv.max(axis=0)).astype(int), [depth.shape[1] - 1, depth.shape[0] - 1])
    if (first > last).any():
        return
    u, v = np.arange(first[0], last[0] + 1)[None, :], np.arange(first[1], last[1] + 1)[:, None]
    weight_a = ((bx - u) * (cy - v) - (by - v) * (cx - u)) / doubled_area
    weight_b = ((cx - u) * (ay - v) - (cy - v) * (ax - u)) / doubled_area
    weight_c = 1.0 - weight_a - weight_b
    inside = (weight_a >= 0) & (weight_b >= 0) & (weight_c >= 0)
    window = depth[first[1] : last[1] + 1, first[0] : last[0] + 1]
    z = 1.0 / np.where(inside, weight_a * inverse_z[0] + weight_b * inverse_z[1] + weight_c * inverse_z[2], 1.0)
    np.minimum(window, np.where(inside, z, np.inf), out=window)
