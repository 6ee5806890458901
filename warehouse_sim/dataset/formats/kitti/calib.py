"""KITTI's calibration and ground plane files."""

from collections.abc import Mapping

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.fisheye import Fisheye
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.schema import LidarScan, MountedReading

_KEYS = ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
"""The seven lines in the order by which loaders find them."""


def calib_text(camera: PinholeCamera, T_camera_lidar: Transform, baseline: float = 0.0) -> str:
    """Return the seven lines of a calib file; behind a lens two more for each camera.

    The left camera serves as P0 and P2, so that its frame is the reference frame of the labels, the right one as P1 and
    P3; without a right camera the one serves as all four. The IMU is the LiDAR. A lens does not fit into P2, which is
    that of the pinhole: K_02 and D_02 (k1 k2 p1 p2 k3) follow, as in KITTI's calib_cam_to_cam.txt, K_03 and D_03 too.
    A fisheye has F_02 (k1 k2 k3 k4) in place of D_02.

    Args:
        camera: Intrinsics of both cameras.
        T_camera_lidar: Pose of the main LiDAR in the left camera's frame.
        baseline: From the left camera to the right one (m); 0 = there is none.
    """
    left = np.hstack([camera.K, np.zeros((3, 1))])
    right = np.hstack([camera.K, [[-camera.fx * baseline], [0.0], [0.0]]])
    values = (left, right, left, right, np.eye(3), T_camera_lidar[:3], np.eye(4)[:3])
    text = "".join(f"{key}: {_row(matrix)}\n" for key, matrix in zip(_KEYS, values, strict=True))
    if camera.distortion is None:
        return text
    lens = "F" if isinstance(camera.distortion, Fisheye) else "D"
    rows = {"K": _row(camera.K), lens: _row(np.array(camera.distortion.coefficients))}
    names = [f"{key}_{eye}" for eye in (("02", "03") if baseline else ("02",)) for key in ("K", lens)]
    return text + "".join(f"{name}: {rows[name[0]]}\n" for name in names)


def lidars_text(lidars: Mapping[str, MountedReading[LidarScan]]) -> str:
    """Return the poses of further LiDARs, one line ``Tr_NAME_to_cam:`` with 3 x 4 numbers each."""
    return "".join(f"Tr_{name}_to_cam: {_row(item.T_camera_sensor[:3])}\n" for name, item in lidars.items())


def plane_text(T_world_camera: Transform) -> str:
    """Return the floor as a x + b y + c z + d = 0 in the camera frame, (a, b, c) up, d the height in m."""
    a, b, c = invert(T_world_camera)[:3, 2] + 0.0
    row = " ".join(f"{value:.9e}" for value in (a, b, c, T_world_camera[2, 3]))
    return f"# Plane\nWidth 4\nHeight 1\n{row}\n"


def _row(matrix: np.ndarray) -> str:
    return " ".join(f"{value:.12e}" for value in (matrix + 0.0).ravel())
