"""A LiDAR in place of the depth camera: an image whose depth is that of a sweep."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.source import DepthSource
from warehouse_sim.estimators.lidar.upsample import UpsampleConfig, upsample
from warehouse_sim.estimators.rgbd_image import RgbdImage


def with_lidar_depth(
    image: RgbdImage,
    points: Float[np.ndarray, "n 3"],
    source: DepthSource = "lidar",
    config: UpsampleConfig = UpsampleConfig(),  # noqa: B008  frozen
) -> RgbdImage:
    """Return the image with the depth of a sweep.

    Args:
        image: Of any camera; its own depth is not looked at.
        points: Of the sweep in the frame of that camera (m).
        source: "lidar" or "lidar-sparse"; "camera" returns the image as it is.
        config: How the sparse depth is filled.
    """
    if source == "camera":
        return image
    depth = sparse_depth(image.camera, points).depth
    return replace(image, depth=upsample(depth, config) if source == "lidar" else depth)
