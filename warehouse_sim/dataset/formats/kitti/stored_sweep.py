"""The main LiDAR's sweep of a dataset with a manifest, from its KITTI files."""

from pathlib import Path

import numpy as np

from warehouse_sim.dataset.formats.kitti.external_frame import KittiFrame, read_sweep
from warehouse_sim.dataset.formats.kitti.layout import frames_of, kitti_layout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.level_view import levelled
from warehouse_sim.geometry.pose import invert
from warehouse_sim.schema import LidarScan, MountedReading


def stored_sweep(root: Path, manifest: Manifest, image: ImageRecord) -> MountedReading[LidarScan]:
    """Read the sweep of an image, with ids, rings and times, and where its sensor was in the rig's own camera.

    KITTI's calibration leads into the level camera, which has the place and the heading of the rig's.

    Raises:
        DatasetError: A file is missing or malformed.
    """
    number = frames_of(manifest, image.scene_id)[image.image_id]
    frame = KittiFrame(kitti_layout(root).folder(image.split), f"{number:06d}")
    stored, T_level_lidar = read_sweep(frame), frame.calibration().T_camera_lidar
    if stored is None or stored.instance_ids is None or stored.beams is None or T_level_lidar is None:
        raise DatasetError(f"{frame.folder}: frame {frame.name} lacks velodyne, its ids, its beams or its calibration")
    T_camera_level = invert(image.T_world_camera) @ levelled(image.T_world_camera)
    scan = LidarScan(
        stored.points,
        stored.intensity,
        stored.instance_ids.astype(np.int32),
        np.rint(stored.beams[:, 0]).astype(np.int32),
        stored.beams[:, 1].astype(np.float32),
    )
    return MountedReading(T_camera_level @ T_level_lidar, scan)
