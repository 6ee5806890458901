"""What formats cannot hold of a resolved recipe: refused before anything is made, with the setting that causes it."""

import math
from collections.abc import Iterator
from typing import Any

from warehouse_sim.dataset.image_io import farthest_depth
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.writers.kitti_calib import LARGEST_LIDAR_TILT
from warehouse_sim.errors import DatasetError

_LARGEST_FRAME = 999_999


def require_depth_fits(recipe: dict[str, Any], steps_per_metre: float, name: str) -> None:
    """Refuse a depth camera that reads farther than 16 bits can say.

    Args:
        recipe: The resolved recipe as the manifest holds it; one that says nothing about sensors passes.
        steps_per_metre: Of the format's depth images.
        name: The format's, as in ``--formats``.

    Raises:
        DatasetError: A largest range, the rig's own or a twin's, is beyond the format's.
    """
    limit = farthest_depth(steps_per_metre)
    for setting, depth in _depth_cameras(recipe):
        if depth.get("max_range", 0.0) > limit:
            raise DatasetError(
                f"{name.upper()}: {setting}.max_range is {depth['max_range']:g} m, but depth in 16 bits ends at "
                f"{limit:.3f} m; lower it, or leave {name} out of --formats"
            )


def require_numbers(manifest: Manifest) -> None:
    """Refuse more frames than KITTI's file names have numbers.

    Raises:
        DatasetError: They need more than six digits.
    """
    if manifest.scenes * manifest.observations_per_scene > _LARGEST_FRAME + 1:
        raise DatasetError(
            f"KITTI: {manifest.scenes} scenes of {manifest.observations_per_scene} observations need more than six "
            "digits; make several datasets with fewer --scenes, or leave kitti out of --formats"
        )


def require_words(targets: tuple[str, ...]) -> None:
    """Refuse class names that cannot stand in a row of blanks and ASCII.

    Raises:
        DatasetError: A target's class is no single word, or KITTI's own DontCare.
    """
    for name in targets:
        if len(name.split()) != 1 or name != name.strip() or not name.isascii() or name == "DontCare":
            raise DatasetError(
                f"KITTI: targets: the class name {name!r} must be one ASCII word other than DontCare in a KITTI label; "
                "rename the class, or leave kitti out of --formats"
            )


def require_level_recipe(recipe: dict[str, Any]) -> None:
    """Refuse a recipe whose cameras can be tilted.

    Args:
        recipe: The resolved recipe as the manifest holds it; one that says nothing about viewpoints passes.

    Raises:
        DatasetError: A kind of camera other than ``level`` is asked for, and not to be level.
    """
    views = recipe.get("scene", {}).get("viewpoints", {})
    kinds, level = _choices(views.get("kind", "level")), _choices(views.get("level", False))
    tilted = [kind for kind in kinds if kind != "level"]
    if tilted and not all(level):
        raise DatasetError(
            f"KITTI: viewpoints.kind {', '.join(tilted)} tilts the camera, but a KITTI label stands upright in the "
            "camera's frame; set viewpoints.level: true in the recipe, or leave kitti out of --formats"
        )


def require_level_lidar(recipe: dict[str, Any]) -> None:
    """Refuse a rig without a main LiDAR, or with one that does not stand upright on a level camera or vehicle.

    Args:
        recipe: The resolved recipe as the manifest holds it; one that says nothing about sensors passes.

    Raises:
        DatasetError: There is none, or its mount leans by more than KITTI's readers bear.
    """
    sensors = recipe.get("sensors", {})
    if "lidar" in sensors and sensors["lidar"] is None:
        raise DatasetError(
            "KITTI: sensors.lidar is null, but every KITTI frame has a sweep; give the recipe a LiDAR, or leave kitti "
            "out of --formats"
        )
    mount = sensors.get("lidar_mount") or {}
    pitch, roll = (float(mount.get(key, 0.0)) for key in ("pitch_deg", "roll_deg"))
    # Yaw, then pitch, then roll: the z axis rises by the product of both cosines.
    tilt = math.acos(math.cos(math.radians(pitch)) * math.cos(math.radians(roll)))
    if tilt > LARGEST_LIDAR_TILT:
        raise DatasetError(
            f"KITTI: sensors.lidar_mount tilts the LiDAR by {math.degrees(tilt):.2f} deg (pitch_deg {pitch:g}, "
            f"roll_deg {roll:g}), but KITTI's readers take its z axis for vertical; keep it within "
            f"{math.degrees(LARGEST_LIDAR_TILT):g} deg, mount it under sensors.lidars, or leave kitti out of --formats"
        )


def _depth_cameras(recipe: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the settings of every depth camera and where the recipe has them."""
    yield "sensors.rgbd.depth", recipe.get("sensors", {}).get("rgbd", {}).get("depth", {})
    for number, twin in enumerate(recipe.get("twins", {}).get("noise", [])):
        yield f"twins.noise[{number}].rgbd.depth", (twin.get("rgbd") or {}).get("depth", {})


def _choices(value: Any) -> list[Any]:
    """Return the values that a setting of a recipe can take: itself, or those it is drawn from."""
    return list(value["choices"]) if isinstance(value, dict) else [value]
