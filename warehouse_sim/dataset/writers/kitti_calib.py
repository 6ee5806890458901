"""KITTI's calibration and ground plane files, and the demand behind them: camera and LiDAR stand level."""

import math
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.schema import LidarScan, MountedReading, Observation

_LARGEST_CAMERA_TILT = math.radians(0.1)
LARGEST_LIDAR_TILT = math.radians(2.0)
"""Real KITTI's own LiDAR is mounted up to about one degree off."""
CALIB_KEYS = ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
"""The seven lines in the order by which loaders find them."""


def require_level(observation: Observation, where: str) -> None:
    """Refuse what a KITTI label cannot say: its only angle is about the camera's y axis, which must be vertical.

    Raises:
        DatasetError: The camera or the LiDAR is tilted.
    """
    world_up = np.array([0.0, 0.0, 1.0])
    camera_up = -observation.T_world_camera[:3, 1]
    tilt = _angle(camera_up, world_up)
    if tilt > _LARGEST_CAMERA_TILT:
        raise DatasetError(
            f"{where}: the camera is tilted by {math.degrees(tilt):.2f} deg, KITTI needs a level camera; "
            "set viewpoints.level: true in the recipe, or leave kitti out of --formats"
        )
    tilt = _angle(observation.T_camera_lidar[:3, 2], np.array([0.0, -1.0, 0.0]))
    if tilt > LARGEST_LIDAR_TILT:
        raise DatasetError(
            f"{where}: the LiDAR is tilted by {math.degrees(tilt):.2f} deg against the camera, KITTI readers take its "
            "z axis for vertical; mount it level, or leave kitti out of --formats"
        )


_LENS_KEYS = ("K", "D")
"""Lines of KITTI's raw calibration for pictures that are not rectified."""


def calib_text(camera: PinholeCamera, T_camera_lidar: Transform, baseline: float = 0.0) -> str:
    """Return the seven lines of a calib file; behind a lens two more for each camera.

    The left camera serves as P0 and P2, so that its frame is the reference frame of the labels, the right one as P1 and
    P3; without a right camera the one serves as all four. The IMU is the LiDAR. A lens does not fit into P2, which is
    that of the pinhole: K_02 and D_02 (k1 k2 p1 p2 k3) follow, as in KITTI's calib_cam_to_cam.txt, K_03 and D_03 too.

    Args:
        camera: Intrinsics of both cameras.
        T_camera_lidar: Pose of the main LiDAR in the left camera's frame.
        baseline: From the left camera to the right one (m); 0 = there is none.
    """
    left = np.hstack([camera.K, np.zeros((3, 1))])
    right = np.hstack([camera.K, [[-camera.fx * baseline], [0.0], [0.0]]])
    values = (left, right, left, right, np.eye(3), T_camera_lidar[:3], np.eye(4)[:3])
    text = "".join(f"{key}: {_row(matrix)}\n" for key, matrix in zip(CALIB_KEYS, values, strict=True))
    if camera.distortion is None:
        return text
    rows = {"K": _row(camera.K), "D": _row(np.array(camera.distortion.coefficients))}
    names = [f"{key}_{eye}" for eye in (("02", "03") if baseline else ("02",)) for key in _LENS_KEYS]
    return text + "".join(f"{name}: {rows[name[0]]}\n" for name in names)


def lidars_text(lidars: Mapping[str, MountedReading[LidarScan]]) -> str:
    """Return the poses of further LiDARs, one line ``Tr_NAME_to_cam:`` with 3 x 4 numbers each."""
    return "".join(f"Tr_{name}_to_cam: {_row(item.T_camera_sensor[:3])}\n" for name, item in lidars.items())


def parse_calib(text: str, where: str) -> dict[str, Float[np.ndarray, "rows columns"]]:
    """Read a calib file as strictly as the strictest reader does.

    Raises:
        DatasetError: Not the seven lines in order, each ``KEY: v v ...`` with single blanks, alone or with those of
            one or two lenses.
    """
    lines = text.split("\n")
    lens_keys = [f"{key}_{eye}" for eye in ("02", "03") for key in _LENS_KEYS]
    more = len(lines) - len(CALIB_KEYS) - 1
    if more not in (0, len(_LENS_KEYS), len(lens_keys)) or lines[-1]:
        raise DatasetError(f"{where}: {len(CALIB_KEYS)} lines and no blank one are expected")
    shapes = {key: (3, 3 if key == "R0_rect" else 4) for key in CALIB_KEYS}
    shapes |= {key: (3, 3) if key[0] == "K" else (1, 5) for key in lens_keys[:more]}
    return {key: _matrix(line, key, shape, where) for line, (key, shape) in zip(lines, shapes.items(), strict=False)}


def calib_camera(matrices: Mapping[str, Float[np.ndarray, "rows columns"]], size_wh: tuple[int, int]) -> PinholeCamera:
    """Return camera 2 of a calib file as read, with its lens if it has one.

    Args:
        matrices: What ``parse_calib`` returns.
        size_wh: Width and height of the images (px), which the file does not hold.

    Raises:
        DatasetError: P2 is that of no camera.
    """
    (fx, _, cx), (_, fy, cy) = matrices["P2"][:2, :3]
    distortion = Distortion(*matrices["D_02"][0].tolist()) if "D_02" in matrices else None
    if min(fx, fy) <= 0.0:
        raise DatasetError(f"P2 of a calib file must have focal lengths above 0, found {fx} and {fy}")
    return PinholeCamera(*size_wh, float(fx), float(fy), float(cx), float(cy), distortion)


def plane_text(T_world_camera: Transform) -> str:
    """Return the floor as a x + b y + c z + d = 0 in the camera frame, (a, b, c) up, d the height in m."""
    a, b, c = invert(T_world_camera)[:3, 2] + 0.0
    row = " ".join(f"{value:.9e}" for value in (a, b, c, T_world_camera[2, 3]))
    return f"# Plane\nWidth 4\nHeight 1\n{row}\n"


def _matrix(line: str, key: str, shape: tuple[int, int], where: str) -> Float[np.ndarray, "rows columns"]:
    name, *words = line.split(" ")
    try:
        values = np.array([float(word) for word in words])
    except ValueError as problem:
        raise DatasetError(f"{where}: {key} holds something else than numbers ({problem})") from problem
    count = shape[0] * shape[1]
    if name != f"{key}:" or values.size != count or not np.isfinite(values).all():
        raise DatasetError(f"{where}: expected '{key}:' and {count} numbers, found {line[:60]!r}")
    return values.reshape(shape)


def _row(matrix: np.ndarray) -> str:
    return " ".join(f"{value:.12e}" for value in (matrix + 0.0).ravel())


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    # Half the chord between unit vectors: arccos would lose small angles.
    return 2.0 * math.asin(min(float(np.linalg.norm(a - b)) / 2.0, 1.0))
