"""An observation as Open3D knows it, and a window of it."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from warehouse_sim.dataset.viewing.screen import require_screen
from warehouse_sim.optional import require

if TYPE_CHECKING:
    from warehouse_sim.api.observation import Observation

_PURPOSE = "to use Open3D"
_FARTHEST = 1000.0
_GREEN = (0.18, 0.8, 0.44)


class Open3dView(NamedTuple):
    """What Open3D's functions take; axes are the camera's, lengths metres."""

    rgbd: Any
    """``open3d.geometry.RGBDImage``: 8-bit colour, depth in metres."""
    camera: Any
    """``open3d.camera.PinholeCameraIntrinsic``; Open3D has no lenses, so of a lens only the pinhole."""
    cloud: Any
    """``open3d.geometry.PointCloud`` of all depth readings, in colour; a lens is taken into account."""


def open3d_view(obs: "Observation") -> Open3dView:
    """Return an observation as Open3D knows it.

    Raises:
        MissingPackageError: Open3D is not installed.
        DatasetError: The dataset holds no colour, no depth or no calibration.
    """
    o3d = require("open3d", "open3d", _PURPOSE)
    camera, rgb, depth = obs.camera, np.ascontiguousarray(obs.rgb), np.ascontiguousarray(obs.depth)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(obs.points.astype(float)))
    cloud.colors = o3d.utility.Vector3dVector(rgb[depth > 0] / 255.0)
    rgbd = o3d.geometry.RGBDImage.create_from_color_and_depth(
        o3d.geometry.Image(rgb), o3d.geometry.Image(depth), 1.0, _FARTHEST, False
    )
    intrinsic = o3d.camera.PinholeCameraIntrinsic(
        camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy
    )
    return Open3dView(rgbd, intrinsic, cloud)


def show(obs: "Observation") -> None:
    """Open a window with cloud and boxes, until the user closes it.

    Raises:
        MissingPackageError: Open3D is not installed.
        InputError: There is no screen.
    """
    require_screen("Open3D", "write a page with --html FILE.html, or serve one with --web")
    o3d = require("open3d", "open3d", _PURPOSE)
    boxes = [_box(o3d, item.T_camera_object, item.size) for item in obs.objects if item.T_camera_object is not None]
    o3d.visualization.draw_geometries(
        [open3d_view(obs).cloud, *boxes],
        f"scene {obs.scene_id}, image {obs.image_id}",
        front=(0, 0, -1),
        up=(0, -1, 0),
        lookat=(0, 0, 4),
        zoom=0.4,
    )


def _box(o3d: Any, T_camera_object: np.ndarray, size: np.ndarray) -> Any:
    box = o3d.geometry.OrientedBoundingBox(T_camera_object[:3, 3], T_camera_object[:3, :3], size)
    box.color = _GREEN
    return box
