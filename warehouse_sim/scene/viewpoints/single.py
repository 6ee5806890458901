"""One view at a time: a vehicle that stands before a target, or a camera on a shell around it."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import is_framed, is_off_axis
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import Mounting, pose_on_floor
from warehouse_sim.schema import ObjectInstance, Viewpoint

TRIES = 60
"""Views drawn for a target before it is given up."""
_OFF_AXIS = 0.9
"""Fraction of ``max_elevation_deg`` within which an overhead camera has its target."""
_FLATTEST = np.deg2rad(15.0)
"""Least angle below the horizon at which an overhead camera sees its target (rad): it hangs no farther away."""
_BEFORE_FACE_DEG = 15.0
"""Largest angle between the line of sight to a face and straight into it (deg), of a truck that comes to take it."""
_ALONG_SPREAD_DEG = 4.0
"""Standard deviation of a view along the aisle against the aisle (deg)."""


def candidate_viewpoints(
    target: ObjectInstance,
    space: FreeSpace,
    config: ViewpointsConfig,
    rng: np.random.Generator,
    tries: int = TRIES,
    sight: tuple[float, float] = (0.0, 1.0),
    into: float | None = None,
) -> Iterator[Viewpoint]:
    """Yield single views of ``target`` that have room and show its centre near the optical axis.

    Args:
        target: What to look at, one of the space's targets.
        space: The scene.
        config: Kind of camera, distances, angles; ``min_targets`` and ``sight_fraction`` are left to the caller.
        rng: Where draws come from.
        tries: Views to draw; fewer are yielded.
        sight: Least and largest fraction of the target's sample points in sight, 0-1: a quick guess, from boxes, of the
            visible fraction.
        into: Heading straight into a face of the target (rad, world), for views of a truck that comes to take it.
    """
    for _ in range(tries):
        sampled = sample_view(target, space, config, rng, into)
        if sampled is None:
            continue
        viewpoint, lift = sampled
        is_good = is_framed(viewpoint.T_world_camera, target.T_world_object[:3, 3], config)
        if not is_good or not space.is_clear(viewpoint, config.clearance, lift):
            continue
        if sight == (0.0, 1.0) or sight[0] <= space.sight_fraction(viewpoint.T_world_camera[:3, 3], target) <= sight[1]:
            yield viewpoint


def sample_view(
    target: ObjectInstance,
    space: FreeSpace,
    config: ViewpointsConfig,
    rng: np.random.Generator,
    into: float | None = None,
) -> tuple[Viewpoint, float] | None:
    """Draw a view of ``target`` and how far the forks are lifted (m); whether there is room is not asked.

    With ``into`` it is one from before the face that this heading (rad, world) goes straight into. None stands for most
    of the views that have the target too far from the optical axis.
    """
    mounting = config.mounting
    if mounting is None:
        return _on_shell(target, config, rng), 0.0
    if mounting.overhead:
        return _overhead(target, mounting, config, rng), 0.0
    if into is not None:
        bearing = into + np.deg2rad(rng.uniform(-_BEFORE_FACE_DEG, _BEFORE_FACE_DEG))
        (x, y), yaw = _sample_mount_before(target.T_world_object[:3, 3], bearing, config, rng)
    elif config.along_fraction and rng.random() < config.along_fraction:
        (x, y), yaw = _sample_along(target.T_world_object[:3, 3], config, space.area, rng)
    else:
        # Those of the aisle are seen against the rack.
        into_rack = -np.pi / 2 if target.T_world_object[1, 3] < space.area.y_min else np.pi / 2
        bearing = into_rack + np.deg2rad(config.approach_deg.sample(rng))
        (x, y), yaw = _sample_mount_before(target.T_world_object[:3, 3], bearing, config, rng)
    height, pitch, roll = sample_mount(mounting, config, rng)
    lift = sample_lift(config, target, space, rng)
    place = float(x), float(y), height + lift
    if is_off_axis(target.T_world_object[:3, 3].tolist(), place, (yaw, pitch, roll), config):
        return None
    T_world_vehicle = pose_on_floor(x - mounting.forward * np.cos(yaw), y - mounting.forward * np.sin(yaw), yaw)
    T_world_camera = level_camera(np.array(place), yaw, pitch, roll)
    return Viewpoint(T_world_camera, config.kind, T_world_vehicle, target=target.instance_id), lift


def sample_mount(mounting: Mounting, config: ViewpointsConfig, rng: np.random.Generator) -> tuple[float, float, float]:
    """Return height above the floor with lowered forks (m), pitch and roll (rad) of a camera."""
    height = (config.height or mounting.height).sample(rng)
    if config.level:
        return height, 0.0, 0.0
    pitch, roll = (config.pitch_deg or mounting.pitch_deg).sample(rng), config.roll_deg.sample(rng)
    return height, float(np.deg2rad(pitch)), float(np.deg2rad(roll))


def sample_lift(config: ViewpointsConfig, target: ObjectInstance, space: FreeSpace, rng: np.random.Generator) -> float:
    """Return how far the forks are up (m): as the recipe says, or anywhere up to where they could enter the target."""
    if config.mounting is None or not config.mounting.lifts:
        return 0.0
    if isinstance(config.lift, Distribution):
        return config.lift.sample(rng)
    if config.lift is None and config.height is not None:
        return 0.0
    stands_at = target.T_world_object[2, 3] - space.models[target.model].size[2] / 2
    return float(rng.uniform(0.0, max(0.0, stands_at)))


def _on_shell(target: ObjectInstance, config: ViewpointsConfig, rng: np.random.Generator) -> Viewpoint:
    """Draw a place on a spherical shell around ``target`` and look at its centre, without roll."""
    radius, azimuth = config.distance.sample(rng), rng.uniform(-np.pi, np.pi)
    elevation = np.deg2rad(config.elevation_deg.sample(rng))
    flat = np.cos(elevation)
    outward = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
    place = target.T_world_object[:3, 3] + radius * outward
    T_world_camera = level_camera(place, azimuth + np.pi, 0.0 if config.level else -float(elevation))
    return Viewpoint(T_world_camera, config.kind, target=target.instance_id)


def _overhead(
    target: ObjectInstance, mounting: Mounting, config: ViewpointsConfig, rng: np.random.Generator
) -> Viewpoint:
    """Hang a camera so that its pitch brings ``target`` near the optical axis, seen from within ``approach_deg``."""
    height, pitch, roll = sample_mount(mounting, config, rng)
    below = _OFF_AXIS * np.deg2rad(config.max_elevation_deg) * rng.uniform(-1.0, 1.0)
    sight = np.clip(pitch + below, -np.pi / 2, -_FLATTEST)
    middle = target.T_world_object[:3, 3]
    back = max(height - middle[2], 0.0) / np.tan(-sight)
    bearing = np.pi / 2 + np.deg2rad(config.approach_deg.sample(rng))
    x, y = middle[:2] - back * np.array([np.cos(bearing), np.sin(bearing)])
    yaw = float(bearing + np.deg2rad(config.offset_deg.sample(rng)))
    T_world_camera = level_camera(np.array([x, y, height]), yaw, pitch, roll)
    return Viewpoint(T_world_camera, config.kind, pose_on_floor(x, y, yaw), target=target.instance_id)


def _sample_along(
    target: Float[np.ndarray, " 3"], config: ViewpointsConfig, area: Area, rng: np.random.Generator
) -> tuple[Float[np.ndarray, " 2"], float]:
    """Draw where a camera that looks along the aisle stands (m) and looks (rad), anywhere across it."""
    aside = target[1] - rng.uniform(area.y_min, area.y_max)
    ahead = np.sqrt(max(config.distance.sample(rng) ** 2 - aside**2, 0.0))
    way = 2 * int(rng.integers(2)) - 1
    yaw = (0.0 if way > 0 else np.pi) + np.deg2rad(rng.normal(0.0, _ALONG_SPREAD_DEG))
    return target[:2] - np.array([way * ahead, aside]), float(yaw)


def _sample_mount_before(
    target: Float[np.ndarray, " 3"], bearing: float, config: ViewpointsConfig, rng: np.random.Generator
) -> tuple[Float[np.ndarray, " 2"], float]:
    """Draw where a camera stands (m) and looks (rad) that has ``target`` in the direction ``bearing`` (rad)."""
    back = config.distance.sample(rng)
    place = target[:2] - back * np.array([np.cos(bearing), np.sin(bearing)])
    yaw = bearing + np.deg2rad(config.offset_deg.sample(rng))
    return place, float(yaw)
