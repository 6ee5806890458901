"""Draw a mesh's depth without a graphics library: the referee for poses, masks and depth on disk."""

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, transform_points

_NEAR = 0.05
_ALONG_EDGE, _SAG_PX = 17, 3.0
"""Points on an edge behind a lens, and by how much the curve between two of them may bulge."""


def mesh_depth(
    mesh: TriangleMesh, T_camera_object: Transform, camera: PinholeCamera
) -> Float[np.ndarray, "h w"] | None:
    """Return the z-depth (m) of a closed mesh at every pixel centre, infinity where it is not; None if it is too near.

    Each triangle covers the pixels inside its three edges; 1/z is linear over the image (Pineda 1988; perspective
    correction as in Blinn 1992). Behind a lens this holds on the pinhole's image, where each pixel then has its place.

    Args:
        mesh: Surface in the object frame (m).
        T_camera_object: Its pose.
        camera: Pixel centres at integers.
    """
    points = transform_points(T_camera_object, mesh.vertices)
    depth = np.full((camera.height, camera.width), np.inf)
    if points[:, 2].min() < _NEAR:
        return None
    inverse_z = 1.0 / points[:, 2]
    if camera.distortion is not None:
        _draw_through_lens(depth, points, mesh.faces, camera)
        return depth
    uv = camera.project(points)
    u, v = np.arange(camera.width)[None, :], np.arange(camera.height)[:, None]
    for face in mesh.faces:
        _draw_triangle(depth, uv[face], inverse_z[face], uv[face], (u, v))
    return depth


def _draw_through_lens(
    depth: Float[np.ndarray, "h w"],
    points: Float[np.ndarray, "n 3"],
    faces: Int[np.ndarray, "m 3"],
    camera: PinholeCamera,
) -> None:
    """Draw triangles where the lens shows them: straight in the pinhole's image, looked at where the pixels look."""
    pinhole = camera.pinhole
    uv, inverse_z = pinhole.project(points), 1.0 / points[:, 2]
    u, v = np.moveaxis(pinhole.project(camera.rays()), -1, 0)
    # The outline of a face in the image is curved: its ends do not bound it, points along it do, nearly.
    share = np.linspace(0.0, 1.0, _ALONG_EDGE)[:, None, None, None]
    corners = np.concatenate([points[:, :2] / points[:, 2:], np.ones((len(points), 1))], axis=1)[faces]
    shown = camera.project(corners + share * (np.roll(corners, -1, axis=1) - corners))
    low, high = shown.min(axis=(0, 2)) - _SAG_PX, shown.max(axis=(0, 2)) + _SAG_PX
    for face, *bounds in zip(faces, low, high, strict=True):
        _draw_triangle(depth, uv[face], inverse_z[face], np.array(bounds), (u, v))


def _draw_triangle(
    depth: Float[np.ndarray, "h w"],
    uv: Float[np.ndarray, "3 2"],
    inverse_z: Float[np.ndarray, " 3"],
    around: Float[np.ndarray, "k 2"],
    places: tuple[Float[np.ndarray, "rows w"], Float[np.ndarray, "h columns"]],
) -> None:
    """Draw one triangle into ``depth``, whose pixels look at ``places`` (u, v); ``around`` bounds it in pixels."""
    (ax, ay), (bx, by), (cx, cy) = uv
    doubled_area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    # Counter-clockwise to the eye is a negative area where v points down; anything else is seen from behind.
    if doubled_area >= 0.0:
        return
    first = np.maximum(np.ceil(around.min(axis=0)).astype(int), 0)
    last = np.minimum(np.floor(around.max(axis=0)).astype(int), [depth.shape[1] - 1, depth.shape[0] - 1])
    if (first > last).any():
        return
    columns, rows = slice(first[0], last[0] + 1), slice(first[1], last[1] + 1)
    u = places[0][rows if len(places[0]) > 1 else slice(None), columns]
    v = places[1][rows, columns if places[1].shape[1] > 1 else slice(None)]
    weight_a = ((bx - u) * (cy - v) - (by - v) * (cx - u)) / doubled_area
    weight_b = ((cx - u) * (ay - v) - (cy - v) * (ax - u)) / doubled_area
    weight_c = 1.0 - weight_a - weight_b
    inside = (weight_a >= 0) & (weight_b >= 0) & (weight_c >= 0)
    window = depth[rows, columns]
    z = 1.0 / np.where(inside, weight_a * inverse_z[0] + weight_b * inverse_z[1] + weight_c * inverse_z[2], 1.0)
    np.minimum(window, np.where(inside, z, np.inf), out=window)
