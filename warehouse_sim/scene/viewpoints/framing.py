"""What a recipe asks of a chosen view: targets near enough to its axis and hardly hidden, judged by boxes.

Which targets an image can show at all is ``annotate.in_view``; how much of one it shows, by rays, ``occlusion.sight``.
"""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import ObjectInstance, Viewpoint


def angles_to(
    T_world_camera: Transform, points: Float[np.ndarray, "n 3"]
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return how far ``points`` (world, m) lie beside and above or below the optical axis (rad, both >= 0)."""
    x, y, z = transform_points(invert(T_world_camera), points).T
    return np.abs(np.arctan2(x, z)), np.abs(np.arctan2(y, np.hypot(x, z)))


def is_framed(T_world_camera: Transform, point: Float[np.ndarray, " 3"], config: ViewpointsConfig) -> bool:
    """Return whether ``point`` (world, m) is near enough to the optical axis."""
    bearing, elevation = angles_to(T_world_camera, point[None])
    return bool(
        bearing[0] <= np.deg2rad(config.max_bearing_deg) and elevation[0] <= np.deg2rad(config.max_elevation_deg)
    )


_ROUNDING = 1e-6
"""By so much (rad) a quick look at angles may differ from the exact one."""


def is_off_axis(
    point: Sequence[float], place: Sequence[float], turns: tuple[float, float, float], config: ViewpointsConfig
) -> bool:
    """Return whether a point is so far from the optical axis that ``is_framed`` surely rejects it; quick to ask.

    Args:
        point: In the world (m).
        place: Of the camera in the world (m).
        turns: Yaw, pitch and roll of the camera (rad), as ``level_camera`` takes them.
        config: What counts as near enough.
    """
    yaw, pitch, roll = turns
    away = [end - start for end, start in zip(point, place, strict=True)]
    ahead, left = _turned(away[0], away[1], yaw)
    z, up = _turned(ahead, away[2], pitch)
    x, y = _turned(-left, -up, roll)
    bearing, elevation = math.atan2(x, z), math.atan2(y, math.hypot(x, z))
    return (
        abs(bearing) > math.radians(config.max_bearing_deg) + _ROUNDING
        or abs(elevation) > math.radians(config.max_elevation_deg) + _ROUNDING
    )


def _turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """Return x and y in axes that are turned by ``angle`` (rad)."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x + s * y, c * y - s * x


def targets_in_frame(T_world_camera: Transform, space: FreeSpace, config: ViewpointsConfig) -> list[ObjectInstance]:
    """Return the targets whose centre is near enough to the optical axis, hidden or not, the nearest first."""
    bearing, elevation = angles_to(T_world_camera, space.target_centres)
    near = (bearing <= np.deg2rad(config.max_bearing_deg)) & (elevation <= np.deg2rad(config.max_elevation_deg))
    distance = np.linalg.norm(space.target_centres - T_world_camera[:3, 3], axis=1)
    return [space.targets[index] for index in np.argsort(distance, kind="stable") if near[index]]


def shows(viewpoint: Viewpoint, target: ObjectInstance, space: FreeSpace, config: ViewpointsConfig) -> bool:
    """Return whether ``target``, and in all as many targets as requested, are well in view."""
    framed = targets_in_frame(viewpoint.T_world_camera, space, config)
    if len(framed) < config.min_targets or target.instance_id not in {item.instance_id for item in framed}:
        return False
    eye = viewpoint.T_world_camera[:3, 3]
    if space.sight_fraction(eye, target) < config.sight_fraction:
        return False
    others = [item for item in framed if item.instance_id != target.instance_id]
    return _count_seen(others, eye, space, config) + 1 >= config.min_targets


def target_in_view(
    viewpoint: Viewpoint, space: FreeSpace, config: ViewpointsConfig, aim: ObjectInstance | None = None
) -> ObjectInstance | None:
    """Return ``aim`` while it is well in view, else the nearest target that is; None if fewer than requested are."""
    if aim is not None and shows(viewpoint, aim, space, config):
        return aim
    eye, framed = viewpoint.T_world_camera[:3, 3], targets_in_frame(viewpoint.T_world_camera, space, config)
    for index, item in enumerate(framed):
        if space.sight_fraction(eye, item) >= config.sight_fraction:
            enough = _count_seen(framed[index + 1 :], eye, space, config) + 1 >= config.min_targets
            return item if enough else None
    return None


def _count_seen(
    items: list[ObjectInstance], eye: Float[np.ndarray, " 3"], space: FreeSpace, config: ViewpointsConfig
) -> int:
    """Return how many of ``items`` are hardly hidden from ``eye`` (m), but no more than are needed beside one."""
    seen = 0
    for item in items:
        if seen + 1 >= config.min_targets:
            break
        seen += space.sight_fraction(eye, item) >= config.sight_fraction
    return seen
