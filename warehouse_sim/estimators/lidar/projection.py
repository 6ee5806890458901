"""Sweeps onto images: which point a pixel shows, and depth images of sweeps."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, Int

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.lidar.upsample import HEIGHT_PX, upsample
from warehouse_sim.estimators.settings import DepthSource
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.clouds import cloud_to_depth
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.schema import LidarScan, MountedReading

NEAREST = 0.1
"""Depth (m) below which a point is not before the camera."""


def read_sweep(
    reader: DatasetReader, image: ImageRecord, purpose: str = "", remedy: str = ""
) -> MountedReading[LidarScan]:
    """Return the sweep of an image.

    Args:
        reader: The dataset.
        image: Which image.
        purpose: What it is for, behind a space, and
        remedy: what else helps, for the message.

    Raises:
        DatasetError: There is none.
    """
    mounted = reader.sweep(image)
    if mounted is None:
        raise DatasetError(
            f"{reader.root}: holds no sweep of image {image.scene_id}/{image.image_id}{purpose}; "
            f"generate it with a LiDAR and the format kitti{remedy}"
        )
    return mounted


def sweep_points(mounted: MountedReading[LidarScan]) -> Float[np.ndarray, "n 3"]:
    """Return the points of a sweep in the frame of its image's camera (m)."""
    return transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))


class SparseDepth(NamedTuple):
    """A sweep as a depth image: most pixels are empty."""

    depth: Float32[np.ndarray, "h w"]
    """Metres along the optical axis, 0 = no reading."""
    shown: Int[np.ndarray, "h w"]
    """Which point each pixel shows, -1 = none."""


def sparse_depth(camera: PinholeCamera, points: Float[np.ndarray, "n 3"]) -> SparseDepth:
    """Return the depth image of a cloud; of the points of a pixel the nearest wins.

    Args:
        camera: Of the image, with or without a lens.
        points: In the camera frame (m).
    """
    points = np.asarray(points, dtype=float)
    ahead = np.flatnonzero(points[:, 2] > NEAREST)
    low_x, high_x, low_y, high_y = camera.tangent_bounds()
    x, y = (points[ahead, :2] / points[ahead, 2:]).T
    # A lens is defined where the image is: beyond, its polynomial may lead back into it.
    ahead = ahead[(x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y)]
    depth, index = cloud_to_depth(points[ahead], camera)
    return SparseDepth(depth.astype(np.float32), np.where(index >= 0, ahead[index], -1) if len(ahead) else index)


def with_lidar_depth(
    image: RgbdImage,
    points: Float[np.ndarray, "n 3"],
    source: DepthSource = "lidar",
    height_px: int = HEIGHT_PX,
) -> RgbdImage:
    """Return the image with the depth of a sweep.

    Args:
        image: Of any camera; its own depth is not looked at.
        points: Of the sweep in the frame of that camera (m).
        source: "lidar" or "lidar-sparse"; "camera" returns the image as it is.
        height_px: Height of the window in which sparse depth is filled, see ``upsample``.
    """
    if source == "camera":
        return image
    depth = sparse_depth(image.camera, points).depth
    return replace(image, depth=upsample(depth, height_px) if source == "lidar" else depth)
