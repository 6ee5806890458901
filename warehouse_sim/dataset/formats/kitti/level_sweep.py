"""The sweep of a LiDAR that leans, in a level frame: KITTI's readers take the LiDAR's z axis for vertical."""

from dataclasses import replace

import numpy as np

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.stored.observation_record import lidar_leans
from warehouse_sim.dataset.stored.recipe_contents import lidar_tilts
from warehouse_sim.geometry.level_view import upright
from warehouse_sim.geometry.pose import invert, make_transform, rotation_x, rotation_y
from warehouse_sim.schema import LIDAR, LidarScan, MountedReading, Observation


def level_sweep(observation: Observation) -> MountedReading[LidarScan]:
    """Return the main sweep with the pose of its frame in the camera's.

    The frame is the LiDAR's own unless that leans by more than 2 deg: then it is at the same place with its z axis up,
    and the points, in their order, are turned into it.
    """
    mounted = observation.readings[LIDAR]
    scan = mounted.reading
    assert isinstance(scan, LidarScan)
    if not lidar_leans(observation.T_world_lidar):
        return MountedReading(mounted.T_camera_sensor, scan)
    T_world_level = upright(observation.T_world_lidar)
    R_level_lidar = T_world_level[:3, :3].T @ observation.T_world_lidar[:3, :3]
    points = (scan.points.astype(float) @ R_level_lidar.T).astype(np.float32)
    return MountedReading(invert(observation.T_world_camera) @ T_world_level, replace(scan, points=points))


def may_lean(manifest: Manifest) -> bool:
    """Return whether the main LiDAR of a recipe leans, or tilts with a camera that may be tilted."""
    contents = manifest.contents
    if contents.lidar is None:
        return False
    pitch, roll = np.deg2rad([contents.lidar.pitch_deg, contents.lidar.roll_deg])
    mounted = make_transform(rotation_y(-pitch) @ rotation_x(roll))
    return lidar_leans(mounted) or bool(contents.tilted_viewpoints and lidar_tilts(manifest.recipe))
