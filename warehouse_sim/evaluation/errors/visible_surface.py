"""VSD: how much of what is seen of a surface lies elsewhere, by depth images of the object in both poses.

The images are those of ``depth_image``, or of any renderer.
"""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.pairing import Group
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.schema import PoseEstimate

_NEAREST = 0.01
"""Surfaces nearer to the camera than this (m) are cut off."""
_PIXELS_AT_ONCE = 2_000_000
_ON_EDGE = 1e-9
_FLAT = 1e-12


def depth_of(mesh: TriangleMesh, T_camera_object: Transform, camera: PinholeCamera) -> Float[np.ndarray, "h w"]:
    """Return the depth (m along z, 0 = none) of an object at the pixel centres of an image.

    Args:
        mesh: Its surface (m, object frame); both sides of a triangle are seen.
        T_camera_object: Its pose.
        camera: Of the image; its lens does not count.
    """
    corners = transform_points(T_camera_object, mesh.vertices)[mesh.faces]
    whole = (corners[..., 2] >= _NEAREST).all(axis=1)
    cut = corners[~whole & (corners[..., 2] > _NEAREST).any(axis=1)]
    triangles = np.concatenate([corners[whole], *(_cut_off(triangle) for triangle in cut)])
    nearest = np.full(camera.height * camera.width, np.inf)
    low, high = _pixel_boxes(triangles, camera)
    size = np.maximum(high - low + 1, 0)
    count = size[:, 0] * size[:, 1]
    triangles, low, size, count = (item[count > 0] for item in (triangles, low, size, count))
    begins = np.concatenate([[0], np.cumsum(count)])
    first = 0
    while first < len(count):
        last = max(int(np.searchsorted(begins, begins[first] + _PIXELS_AT_ONCE, side="right")) - 1, first + 1)
        part = slice(first, last)
        _draw(triangles[part], low[part], size[part], count[part], camera, nearest)
        first = last
    return np.where(np.isfinite(nearest), nearest, 0.0).reshape(camera.height, camera.width)


def _draw(
    triangles: Float[np.ndarray, "m 3 3"],
    low: Int[np.ndarray, "m 2"],
    size: Int[np.ndarray, "m 2"],
    count: Int[np.ndarray, " m"],
    camera: PinholeCamera,
    nearest: Float[np.ndarray, " p"],
) -> None:
    """Put the nearest depth of all pixels in the triangles' boxes into ``nearest``.

    A pixel's ray r = (x, y, 1) passes a triangle a, b, c where the volumes r (b x c), r (c x a), r (a x b) have one
    sign; it meets its plane at z = a (b x c) / sum of these.
    """
    a, b, c = triangles.swapaxes(0, 1)
    sides = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    volume = np.einsum("mi,mi->m", a, sides[:, 0])
    row = np.repeat(np.arange(len(count)), count)
    inside = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    v, u = np.divmod(inside, size[row, 0])
    u, v = u + low[row, 0], v + low[row, 1]
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    parts = sides[row, :, 0] * x[:, None] + sides[row, :, 1] * y[:, None] + sides[row, :, 2]
    total = parts.sum(axis=1)
    hit = np.abs(total) > _FLAT
    fractions = parts[hit] / total[hit, None]
    met = (fractions >= -_ON_EDGE).all(axis=1)
    place, depth = (v * camera.width + u)[hit][met], (volume[row][hit] / total[hit])[met]
    np.minimum.at(nearest, place, depth)


def _pixel_boxes(
    triangles: Float[np.ndarray, "m 3 3"], camera: PinholeCamera
) -> tuple[Int[np.ndarray, "m 2"], Int[np.ndarray, "m 2"]]:
    """Return the first and last column and row whose pixel centres a triangle can cover, within the image."""
    focal, centre = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    last = np.array([camera.width, camera.height]) - 1
    pixels = triangles[..., :2] / triangles[..., 2:] * focal + centre
    low = np.clip(np.ceil(pixels.min(axis=1) - 1e-6), 0, last + 1).astype(np.int64)
    high = np.clip(np.floor(pixels.max(axis=1) + 1e-6), -1, last).astype(np.int64)
    return low, high


def _cut_off(triangle: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "k 3 3"]:
    """Return what of a triangle lies beyond the nearest plane, as one or two triangles."""
    kept = []
    for start, end in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        if start[2] >= _NEAREST:
            kept.append(start)
        if (start[2] >= _NEAREST) != (end[2] >= _NEAREST):
            kept.append(start + (_NEAREST - start[2]) / (end[2] - start[2]) * (end - start))
    return np.array([[kept[0], kept[i], kept[i + 1]] for i in range(1, len(kept) - 1)]).reshape(-1, 3, 3)


BOP_TAUS = tuple(np.arange(0.05, 0.51, 0.05).round(2).tolist())
"""Misalignment tolerances of the BOP challenge, as fractions of the diameter."""
BOP_DELTA = 0.015
"""How far behind the reading a surface counts as visible in the BOP challenge (m)."""


def vsd(
    depth_estimated: Float[np.ndarray, "h w"],
    depth_gt: Float[np.ndarray, "h w"],
    depth_seen: Float[np.ndarray, "h w"],
    camera: PinholeCamera,
    diameter: float,
    taus: Sequence[float] = BOP_TAUS,
) -> Float[np.ndarray, " t"]:
    """Return the visible surface discrepancy (0-1) for each tolerance.

    Hodan et al., BOP (ECCV 2018), equation 2, with the visibility of the challenges since 2019: where the sensor reads
    nothing, the object is taken for visible. Distances are along the ray, not along z.

    Args:
        depth_estimated: The object alone in the estimated pose (m along z, 0 = none).
        depth_gt: The object alone in the true pose.
        depth_seen: What the sensor read.
        camera: Of the images; its lens does not count.
        diameter: Of the object (m).
        taus: Tolerances as fractions of the diameter.
    """
    rays = _ray_lengths(camera)
    estimated, true, seen = rays * depth_estimated, rays * depth_gt, rays * depth_seen
    # In 32 bits, as the public reference compares them: pixels at the very limit would fall to the other side.
    visible_gt = _in_view(true, seen)
    visible_estimated = _in_view(estimated, seen) | (visible_gt & (estimated > 0.0))
    both, either = visible_gt & visible_estimated, int((visible_gt | visible_estimated).sum())
    if either == 0:
        return np.ones(len(taus))
    apart = np.abs(true[both] - estimated[both]) / diameter
    wrong = np.array([(apart >= tau).sum() for tau in taus])
    return (wrong + either - len(apart)) / either


SeenDepth = Callable[[ImageRecord], Float[np.ndarray, "h w"]]
"""Reads what the depth sensor read of an image (m along z, 0 = no reading)."""


def vsd_errors(
    groups: Sequence[Group], predictions: Sequence[PoseEstimate], models: ErrorModels, seen: SeenDepth
) -> list[Float[np.ndarray, "p g t"]]:
    """Return by group the discrepancy of each estimate against each ground truth, at each tolerance.

    Args:
        groups: What can belong together; objects must have CAD.
        predictions: Estimates of all images.
        models: Where surfaces come from.
        seen: Reads depth images.
    """
    errors, last = [], None
    for group in groups:
        found = np.ones((len(group.estimates), len(group.targets), len(BOP_TAUS)))
        errors.append(found)
        if not group.estimates:
            continue
        if last is None or last[0] is not group.image:
            last = group.image, seen(group.image)
        camera, info = group.image.camera, models.info(group.targets[0])
        mesh = info.mesh()
        true = [depth_of(mesh, target.T_camera_object, camera) for target in group.targets]
        for row, index in enumerate(group.estimates):
            estimated = depth_of(mesh, predictions[index].T_camera_object, camera)
            for column, image in enumerate(true):
                # Surfaces that share no pixel differ in all of them.
                if (estimated.astype(bool) & image.astype(bool)).any():
                    found[row, column] = vsd(estimated, image, last[1], camera, info.diameter)
    return errors


def _in_view(distance: Float[np.ndarray, "h w"], seen: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    behind = distance.astype(np.float32) - seen.astype(np.float32)
    return ((behind <= BOP_DELTA) | (seen == 0.0)) & (distance > 0.0)


def _ray_lengths(camera: PinholeCamera) -> Float[np.ndarray, "h w"]:
    """Return the length of the ray to z = 1 of each pixel."""
    x = (np.arange(camera.width) - camera.cx) / camera.fx
    y = (np.arange(camera.height) - camera.cy) / camera.fy
    return np.sqrt(1.0 + x[None] ** 2 + y[:, None] ** 2)
