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
    if camera.distortion is not None:
        _draw_through_lens(depth, points, mesh.faces, camera)
        return depth
    uv = camera.project(points)[mesh.faces]
    places = np.arange(camera.width)[None, :], np.arange(camera.height)[:, None]
    _draw(depth, uv, 1.0 / points[mesh.faces, 2], (uv.min(axis=1), uv.max(axis=1)), places)
    return depth


def _draw_through_lens(
    depth: Float[np.ndarray, "h w"],
    points: Float[np.ndarray, "n 3"],
    faces: Int[np.ndarray, "m 3"],
    camera: PinholeCamera,
) -> None:
    """Draw triangles where the lens shows them: straight in the pinhole's image, looked at where the pixels look."""
    pinhole = camera.pinhole
    u, v = np.moveaxis(pinhole.project(camera.rays()), -1, 0)
    # The outline of a face in the image is curved: its ends do not bound it, points along it do, nearly.
    fraction = np.linspace(0.0, 1.0, _ALONG_EDGE)[:, None, None, None]
    corners = np.concatenate([points[:, :2] / points[:, 2:], np.ones((len(points), 1))], axis=1)[faces]
    shown = camera.project(corners + fraction * (np.roll(corners, -1, axis=1) - corners))
    bounds = shown.min(axis=(0, 2)) - _SAG_PX, shown.max(axis=(0, 2)) + _SAG_PX
    _draw(depth, pinhole.project(points)[faces], 1.0 / points[faces, 2], bounds, (u, v))


def _draw(
    depth: Float[np.ndarray, "h w"],
    uv: Float[np.ndarray, "m 3 2"],
    inverse_z: Float[np.ndarray, "m 3"],
    bounds: tuple[Float[np.ndarray, "m 2"], Float[np.ndarray, "m 2"]],
    places: tuple[Float[np.ndarray, "rows w"], Float[np.ndarray, "h columns"]],
) -> None:
    """Draw triangles into ``depth``.

    Args:
        depth: The image; what is nearer stays.
        uv: Corners on the image that the pixels look at (px).
        inverse_z: 1/z of the corners (1/m).
        bounds: Least and largest u, v of each triangle's pixels.
        places: u and v at which the pixels look.
    """
    height, width = depth.shape
    first = np.maximum(np.ceil(bounds[0]), 0).astype(int)
    last = np.minimum(np.floor(bounds[1]), [width - 1, height - 1]).astype(int)
    ahead, aside = np.diff(uv, axis=1).swapaxes(0, 1)
    # Counter-clockwise to the eye is a negative area where v points down; anything else is seen from behind.
    towards = ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0] < 0.0
    sampled = np.flatnonzero(towards & (first <= last).all(axis=1))
    # Each corner's weight is 1 there and 0 at the two others; weights and 1/z are a + b u + c v.
    weights = np.linalg.inv(np.concatenate([np.ones((len(sampled), 3, 1)), uv[sampled]], axis=2)).swapaxes(1, 2)
    planes = np.concatenate([weights, np.einsum("mi,mij->mj", inverse_z[sampled], weights)[:, None]], axis=1)
    for plane, (left, top), (right, bottom) in zip(planes[..., None, None], first[sampled], last[sampled], strict=True):
        columns, rows = slice(left, right + 1), slice(top, bottom + 1)
        u = places[0][rows if len(places[0]) > 1 else slice(None), columns]
        v = places[1][rows, columns if places[1].shape[1] > 1 else slice(None)]
        *weight, nearness = (plane[:, 0] + plane[:, 1] * u) + plane[:, 2] * v
        inside = (weight[0] >= 0) & (weight[1] >= 0) & (weight[2] >= 0)
        window = depth[rows, columns]
        np.minimum(window, 1.0 / np.where(inside, nearness, 1.0), out=window, where=inside)
