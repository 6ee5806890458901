"""The level virtual camera that sees what a tilted one sees: same place, same heading, another window of its plane."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, level_camera, rotation_x

STEEPEST = np.deg2rad(60.0)
"""Angle to the horizon up to which a level camera's image plane is used; beyond, its pixels show next to nothing."""
_LEVEL = 1e-9
_VERTICAL = 1e-6
_ROUNDING_PX = 1e-6


def is_level(T_world_camera: Transform) -> bool:
    """Return whether a camera looks along the horizon without roll."""
    right, down, ahead = T_world_camera[2, :3]
    return bool(abs(right) < _LEVEL and abs(ahead) < _LEVEL and down < 0)


def levelled(T_world_camera: Transform) -> Transform:
    """Return the pose of the level camera at the same place with the same heading; a level one's is returned itself.

    The heading of a camera that looks straight down is where its image's upper border is, straight up its lower one.
    """
    if is_level(T_world_camera):
        return T_world_camera
    ahead = T_world_camera[:2, 2]
    if np.hypot(*ahead) < _VERTICAL:
        ahead = np.sign(T_world_camera[2, 2]) * T_world_camera[:2, 1]
    return level_camera(T_world_camera[:3, 3], float(np.arctan2(ahead[1], ahead[0])))


def upright(T_world_sensor: Transform) -> Transform:
    """Return the pose at the same place with its z axis up, turned there about a horizontal axis.

    What hangs upside down is turned about its own x axis first, so that it looks ahead as before.
    """
    R = T_world_sensor[:3, :3]
    if R[2, 2] < 0.0:
        R = R @ rotation_x(np.pi)
    x, y, z = R[:, 2]
    # The shortest turn of a unit vector a onto b, I + [a x b] + [a x b]^2 / (1 + a.b), for b = (0, 0, 1).
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    T_world_upright = T_world_sensor.copy()
    T_world_upright[:3, :3] = (np.eye(3) + cross + cross @ cross / (1.0 + z)) @ R
    return T_world_upright


def lean(T_world_sensor: Transform) -> float:
    """Return by how much a z axis leans against the vertical (rad, 0 to pi)."""
    x, y, z = T_world_sensor[:3, 2]
    return float(np.arctan2(np.hypot(x, y), z))


def level_view(camera: PinholeCamera, T_world_camera: Transform) -> tuple[PinholeCamera, Transform]:
    """Return the level pinhole, with its pose, whose image holds all that a camera shows, and no row or column more.

    It has the focal length of the camera, a principal point of its own, which may lie outside the image, and no lens.
    A level pinhole is its own level view.

    Args:
        camera: Intrinsics and lens.
        T_world_camera: Pose of the camera.

    Raises:
        ValueError: The image reaches farther than ``STEEPEST`` from the horizon.
    """
    if camera.distortion is None and is_level(T_world_camera):
        return camera, T_world_camera
    T_world_level = levelled(T_world_camera)
    rays = camera.border_rays() @ (T_world_level[:3, :3].T @ T_world_camera[:3, :3]).T
    if farthest_from_horizon(rays) > STEEPEST:
        raise ValueError(
            f"the image reaches {np.rad2deg(farthest_from_horizon(rays)):.1f} deg from the horizon; "
            f"a level camera sees {np.rad2deg(STEEPEST):g} deg at most"
        )
    on_plane = rays[:, :2] / rays[:, 2:] * [camera.fx, camera.fy]
    (left, top), (right, bottom) = on_plane.min(axis=0), on_plane.max(axis=0)
    width, height = (int(np.ceil(extent - _ROUNDING_PX)) for extent in (right - left, bottom - top))
    return PinholeCamera(width, height, camera.fx, camera.fy, -0.5 - left, -0.5 - top), T_world_level


def reach(camera: PinholeCamera, pitch: float, roll: float) -> float:
    """Return how far from the horizon, in its level view, the image of a tilted camera reaches (rad, 0 to pi).

    Args:
        camera: Intrinsics and lens.
        pitch: Tilt of the optical axis (rad), positive looks up.
        roll: Turn about the optical axis (rad).
    """
    R_world_level, R_world_camera = (level_camera(np.zeros(3), 0.0, *turn)[:3, :3] for turn in ((), (pitch, roll)))
    return farthest_from_horizon(camera.border_rays() @ (R_world_level.T @ R_world_camera).T)


def farthest_from_horizon(rays: Float[np.ndarray, "n 3"]) -> float:
    """Return the largest angle (rad, 0 to pi) to the horizon of rays in a level camera's frame, seen from its side."""
    return float(np.abs(np.arctan2(rays[:, 1], rays[:, 2])).max())
