"""What KITTI cannot hold: of a dataset, rejected before anything is made, and of an observation."""

import math

import numpy as np

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.level_view import STEEPEST
from warehouse_sim.schema import Observation

STEPS_PER_METRE = 256.0
"""Of the depth images."""
_LARGEST_FRAME = 999_999
_LARGEST_CAMERA_TILT = math.radians(0.1)


def require_numbers(manifest: Manifest) -> None:
    """Reject more frames than KITTI's file names have numbers.

    Raises:
        DatasetError: They need more than six digits.
    """
    if manifest.scenes * manifest.observations_per_scene > _LARGEST_FRAME + 1:
        raise DatasetError(
            f"KITTI: {manifest.scenes} scenes of {manifest.observations_per_scene} observations need more than six "
            "digits; make several datasets with fewer --scenes, or leave kitti out of --formats"
        )


def require_words(targets: tuple[str, ...]) -> None:
    """Reject class names that cannot stand in a row of blanks and ASCII.

    Raises:
        DatasetError: A target's class is no single word, or KITTI's own DontCare.
    """
    for name in targets:
        if len(name.split()) != 1 or name != name.strip() or not name.isascii() or name == "DontCare":
            raise DatasetError(
                f"KITTI: targets: the class name {name!r} must be one ASCII word other than DontCare in a KITTI label; "
                "rename the class, or leave kitti out of --formats"
            )


def require_views_near_horizon(contents: Contents) -> None:
    """Reject a recipe whose images can reach farther from the horizon than the level virtual camera sees.

    Raises:
        DatasetError: A camera can be tilted so far that the border of its image is beyond.
    """
    if contents.view_angle_deg > math.degrees(STEEPEST):
        raise DatasetError(
            f"KITTI: viewpoints.kind {', '.join(contents.tilted_viewpoints)} shows what lies "
            f"{contents.view_angle_deg:.0f} deg from the horizon, but the level camera that KITTI is written through "
            f"sees {math.degrees(STEEPEST):.0f} deg; narrow viewpoints.pitch_deg (of free: elevation_deg) or the "
            "camera, or leave kitti out of --formats"
        )


def require_lidar(contents: Contents) -> None:
    """Reject a rig without a main LiDAR.

    Raises:
        DatasetError: There is none.
    """
    if contents.lidar is None:
        raise DatasetError(
            "KITTI: sensors.lidar is null, but every KITTI frame has a sweep; give the recipe a LiDAR, or leave kitti "
            "out of --formats"
        )


def require_level(observation: Observation, where: str) -> None:
    """Reject what a KITTI label cannot say: its only angle is about the camera's y axis, which must be vertical.

    Raises:
        DatasetError: The camera is tilted.
    """
    world_up = np.array([0.0, 0.0, 1.0])
    camera_up = -observation.T_world_camera[:3, 1]
    tilt = _angle(camera_up, world_up)
    if tilt > _LARGEST_CAMERA_TILT:
        raise DatasetError(
            f"{where}: the camera is tilted by {math.degrees(tilt):.2f} deg, KITTI needs a level camera; "
            "hand the writer its level view, set viewpoints.level: true, or leave kitti out of --formats"
        )


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    # Half the chord between unit vectors: arccos would lose small angles.
    return 2.0 * math.asin(min(float(np.linalg.norm(a - b)) / 2.0, 1.0))
