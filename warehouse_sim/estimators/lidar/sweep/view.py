"""How one object is looked at from a LiDAR: its points in a level frame that faces it, and what surrounds them."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree

from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points

_NEAREST = 0.1
"""Depth (m) below which a point is not before the camera."""
DOWN = np.array([0.0, 1.0, 0.0])
"""Gravity in a level frame (x right, y down, z ahead)."""
_SPACING_PX = 3.2
"""Between neighbouring readings, as the filling of depth was made for (64 beams, a focal length of 700 px)."""
_FOCAL_PX = (50.0, 700.0)
"""Least and greatest focal length ..."""
_WIDEST_PX = 480
"""... and less where the image would be larger than this."""
_AROUND = 1.0
"""What is seen of the surroundings on each side (m)."""


@dataclass(frozen=True, eq=False)
class ObjectView(RgbdImage):
    """An image of a level virtual camera at the LiDAR that faces one object, its only detection."""

    own: Float[np.ndarray, "n 3"] = field(default_factory=lambda: np.zeros((0, 3)))
    """The object's points, as the LiDAR read them (frame of that camera, m)."""
    T_lidar_view: Transform = field(default_factory=lambda: np.eye(4))
    """Pose of that camera in the LiDAR frame."""


def facing_points(points: Float[np.ndarray, "n 3"], up: Float[np.ndarray, " 3"]) -> Transform:
    """Return T_lidar_view of a level frame at the LiDAR that looks at the middle of some points (LiDAR frame, m).

    What stands there is in the same place of that frame wherever around the LiDAR it stands.

    Args:
        points: Of an object, not all straight above or below.
        up: Unit vector against gravity (LiDAR frame).
    """
    middle = points.mean(axis=0)
    ahead = middle - up * (middle @ up)
    ahead /= np.linalg.norm(ahead)
    T = np.eye(4)
    T[:3, :3] = np.stack([np.cross(ahead, up), -up, ahead], axis=1)
    return T


def object_view(
    points: Float[np.ndarray, "n 3"],
    own: Bool[np.ndarray, " n"],
    T_lidar_view: Transform,
    detection: Detection,
    place: tuple[int, int] = (0, 0),
) -> ObjectView:
    """Return the view of an object: filled depth about it, in which a pixel is whose its nearest reading is.

    Args:
        points: The sweep (LiDAR frame, m).
        own: Which of them are the object's, at least one.
        T_lidar_view: The frame that faces it.
        detection: What is known of it; its mask in the view takes the place of its own.
        place: Numbers of scene and image.
    """
    seen = transform_points(invert(T_lidar_view), points)
    camera = _camera_about(seen, own)
    sparse = sparse_depth(camera, seen)
    depth = upsample(sparse.depth)
    mask = np.zeros(depth.shape, dtype=bool)
    v, u = np.nonzero(depth > 0)
    shown = sparse.shown[sparse.shown >= 0]
    if len(v):
        nearest = cKDTree(seen[shown]).query(camera.rays_at(u, v) * depth[v, u][:, None])[1]
        mask[v, u] = own[shown[nearest]]
    found = (replace(detection, mask=mask, box_xyxy=None),)
    return ObjectView(camera, depth, found, None, *place, gravity=DOWN, own=seen[own], T_lidar_view=T_lidar_view)


def _camera_about(points: Float[np.ndarray, "n 3"], own: Bool[np.ndarray, " n"]) -> PinholeCamera:
    """Return a level camera whose image holds some of the points (its frame, m), and what is about them."""
    ahead = points[points[:, 2] > _NEAREST]
    tangents, mine = ahead[:, :2] / ahead[:, 2:], points[own]
    z = np.maximum(mine[:, 2], _NEAREST)
    low, high = (bound(mine[:, :2] / z[:, None], axis=0) for bound in (np.min, np.max))
    beyond = _AROUND / float(np.median(z))
    low, high = low - beyond, high + beyond
    near = ((tangents >= low) & (tangents <= high)).all(axis=1)
    spacing = float(np.sqrt((high - low).prod() / max(int(near.sum()), 1)))
    focal = float(np.clip(_SPACING_PX / spacing, *_FOCAL_PX))
    focal = min(focal, _WIDEST_PX / float((high - low).max()))
    width, height = (max(8, int(np.ceil(edge * focal))) for edge in high - low)
    return PinholeCamera(width, height, focal, focal, float(-low[0] * focal - 0.5), float(-low[1] * focal - 0.5))
