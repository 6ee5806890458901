"""Depth images to point clouds and back, normals of a depth image, thinning of a cloud."""

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.camera import PinholeCamera


def depth_to_cloud(
    depth: Float[np.ndarray, "h w"], camera: PinholeCamera
) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, " n"]]:
    """Return the points (m, camera frame) of all pixels with a reading, and each one's number in the flat image.

    Args:
        depth: Metres along the optical axis, 0 = no reading.
        camera: Intrinsics.
    """
    pixels = np.flatnonzero(depth > 0)
    return camera.unproject(depth).reshape(-1, 3)[pixels], pixels


def cloud_to_depth(
    points: Float[np.ndarray, "n 3"], camera: PinholeCamera
) -> tuple[Float[np.ndarray, "h w"], Int[np.ndarray, "h w"]]:
    """Return the depth image (m, 0 = nothing) of a cloud by a z-buffer, and which point each pixel shows (-1 = none).

    A point falls into the pixel whose centre is nearest; the nearest point of a pixel stays, of equal ones the first.

    Args:
        points: Camera frame (m); those at or behind the image plane are left out.
        camera: Intrinsics.
    """
    ahead = np.flatnonzero(points[:, 2] > 0)
    u, v = np.floor(camera.project(points[ahead]) + 0.5).T
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    ahead = ahead[inside]
    pixels = v[inside].astype(np.int64) * camera.width + u[inside].astype(np.int64)
    order = np.lexsort((ahead, points[ahead, 2], pixels))
    shown, first = np.unique(pixels[order], return_index=True)
    index = np.full(camera.width * camera.height, -1)
    index[shown] = ahead[order][first]
    depth = np.where(index >= 0, points[index, 2] if len(points) else 0.0, 0.0)
    shape = camera.height, camera.width
    return depth.reshape(shape), index.reshape(shape)


def depth_normals(
    depth: Float[np.ndarray, "h w"], camera: PinholeCamera, max_jump: float = 0.05
) -> Float[np.ndarray, "h w 3"]:
    """Return unit normals that face the camera, zero where they are not known.

    Per pixel the cross product of the differences between its neighbours below and above, right and left. A normal is
    not known at the border, beside holes, and where depth changes by more than ``max_jump`` of itself.

    Args:
        depth: Metres along the optical axis, 0 = no reading.
        camera: Intrinsics.
        max_jump: Fraction of the depth, > 0.
    """
    points = camera.unproject(depth)
    across = points[1:-1, 2:] - points[1:-1, :-2]
    down = points[2:, 1:-1] - points[:-2, 1:-1]
    normals = np.cross(down, across)
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    known = _smooth(depth, max_jump) & (length[..., 0] > 0)
    result = np.zeros((*depth.shape, 3))
    result[1:-1, 1:-1] = np.where(known[..., None], normals / np.where(length > 0, length, 1.0), 0.0)
    return result


def thin_by_voxels(
    points: Float[np.ndarray, "n 3"], edge: float
) -> tuple[Float[np.ndarray, "m 3"], Int[np.ndarray, " n"]]:
    """Return the mean of the points in each cube of a grid, ordered by cube, and which of them each point went into.

    Args:
        points: Any frame (m).
        edge: Of the cubes (m), > 0; one has its corner at the origin.
    """
    if edge <= 0:
        raise ValueError(f"the edge of a voxel must be positive, found {edge}")
    if not len(points):
        return np.zeros((0, 3)), np.zeros(0, np.int64)
    cells = np.floor(points / edge).astype(np.int64)
    cells -= cells.min(axis=0)
    size = cells.max(axis=0) + 1
    if np.prod(size.astype(float)) < 2.0**62:
        # One number a cube in the order of the cubes: sorted many times faster than rows of three.
        cells = (cells[:, :1] * size[1] + cells[:, 1:2]) * size[2] + cells[:, 2:]
    _, group, count = np.unique(cells, axis=0 if cells.shape[1] > 1 else None, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    sums = np.stack([np.bincount(group, points[:, axis], len(count)) for axis in range(3)], axis=1)
    return sums / count[:, None], group


def _smooth(depth: Float[np.ndarray, "h w"], max_jump: float) -> Bool[np.ndarray, "inner_h inner_w"]:
    """Return for all pixels but the border's whether they and their four neighbours lie on one surface."""
    here = depth[1:-1, 1:-1]
    smooth = here > 0
    for beside in (depth[1:-1, 2:], depth[1:-1, :-2], depth[2:, 1:-1], depth[:-2, 1:-1]):
        smooth &= (beside > 0) & (np.abs(beside - here) <= max_jump * here)
    return smooth
