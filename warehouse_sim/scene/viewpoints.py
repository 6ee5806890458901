"""Where the sensor rig stands: on a forklift in the aisle, level, in front of a pallet it could go for."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import level_camera, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import ObjectInstance, Viewpoint

_TRIES = 60
_EDGE = 0.3
"""Least distance from the camera to the aisle's edge (m)."""
_CLEAR_SHARE = 0.6
"""Share of the sample points of the aimed-at pallet that must be in sight."""


@dataclass(frozen=True)
class ViewpointsConfig:
    """The forklift's camera. Each view aims at one target, drawn evenly from those in the racks or in the aisle."""

    distance: Distribution = field(default=Distribution.uniform(2.0, 8.0))
    """Horizontal distance from the camera to the aimed-at pallet's centre (m), > 1."""
    height: Distribution = field(default=Distribution.uniform(0.4, 3.5))
    """Height of the camera above the floor (m), > 0.1."""
    approach_deg: Distribution = field(default=Distribution.uniform(-30.0, 30.0))
    """Angle between the line of sight to the pallet and the direction straight into the rack (deg)."""
    offset_deg: Distribution = field(default=Distribution.uniform(-15.0, 15.0))
    """Angle between the optical axis and the line of sight to the pallet, seen from above (deg)."""
    aisle_share: float = 0.25
    """Share of the views that aim at a target in the aisle, where there is one, 0-1."""
    max_elevation_deg: float = 10.0
    """Largest angle of the pallet above or below the level optical axis (deg), 1-45."""
    clearance: float = 0.7
    """Least distance from the camera to any object (m), >= 0.2."""

    def __post_init__(self) -> None:
        if self.distance.low <= 1.0:
            raise ValueError(f"distance must stay above 1 m, found {self.distance.low}")
        if self.height.low <= 0.1:
            raise ValueError(f"height must stay above 0.1 m, found {self.height.low}")
        if not 0.0 <= self.aisle_share <= 1.0:
            raise ValueError(f"aisle_share must be 0-1, found {self.aisle_share}")
        if not 1.0 <= self.max_elevation_deg <= 45.0:
            raise ValueError(f"max_elevation_deg must be 1-45, found {self.max_elevation_deg}")
        if self.clearance < 0.2:
            raise ValueError(f"clearance must be >= 0.2 m, found {self.clearance}")


def choose_viewpoints(
    draft: SceneDraft,
    targets: tuple[str, ...],
    count: int,
    config: ViewpointsConfig,
    area: Area,
    rng: np.random.Generator,
) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints in the aisle ``area``, each with a target well in view.

    Raises:
        PlacementError: No free place from which a target can be seen is found.
    """
    candidates = [item for item in draft.instances if draft.models[item.model].class_name in targets]
    if not candidates:
        raise PlacementError(f"no object of the scene is of a target class ({', '.join(targets)})")
    solids = draft.solids()
    world = _World(BoxStack.of([box for _, box in solids]), np.array([owner for owner, _ in solids]), area)
    return tuple(_choose(draft, candidates, config, world, rng) for _ in range(count))


@dataclass(frozen=True, eq=False)
class _World:
    """What a viewpoint is checked against."""

    solids: BoxStack
    owners: Int[np.ndarray, " n"]
    """Instance id of each solid."""
    area: Area


def _choose(
    draft: SceneDraft,
    candidates: list[ObjectInstance],
    config: ViewpointsConfig,
    world: _World,
    rng: np.random.Generator,
) -> Viewpoint:
    wanted = rng.random() < config.aisle_share
    shuffled = [candidates[index] for index in rng.permutation(len(candidates))]
    # All tries of a target before the next one: the hard ones, down on the floor, are seen as often as the easy ones.
    for target in sorted(shuffled, key=lambda item: world.area.contains(item.T_world_object[:3, 3]) != wanted):
        centre, size = target.T_world_object[:3, 3], draft.models[target.model].size
        for _ in range(_TRIES):
            position, yaw = _stand_before(centre, config, world.area, rng)
            if _is_free(position, config, world) and _in_sight(position, target, size, config, world):
                return Viewpoint(level_camera(position, yaw))
    raise PlacementError(
        f"no viewpoint found in {_TRIES} tries for each of {len(candidates)} targets; "
        "widen layout.aisle_width, viewpoints.distance or viewpoints.height"
    )


def _stand_before(
    target: Float[np.ndarray, " 3"], config: ViewpointsConfig, area: Area, rng: np.random.Generator
) -> tuple[Float[np.ndarray, " 3"], float]:
    """Draw a place (m) and a heading (rad) before ``target`` (m); what stands in the aisle is seen against the rack."""
    into_rack = -np.pi / 2 if target[1] < area.y_min else np.pi / 2
    bearing = into_rack + np.deg2rad(config.approach_deg.draw(rng))
    back = config.distance.draw(rng)
    place = target[:2] - back * np.array([np.cos(bearing), np.sin(bearing)])
    yaw = bearing + np.deg2rad(config.offset_deg.draw(rng))
    return np.array([*place, config.height.draw(rng)]), float(yaw)


def _is_free(position: Float[np.ndarray, " 3"], config: ViewpointsConfig, world: _World) -> bool:
    """Return whether a camera at ``position`` stands in the aisle and keeps its distance from every object."""
    if not world.area.contains(position, margin=_EDGE):
        return False
    to_solid = world.solids.distances_to(position)
    # The floor may be nearer: only what stands on it limits the camera.
    return bool(np.min(to_solid[world.solids.centre[:, 2] > 0.0], initial=np.inf) >= config.clearance)


def _in_sight(
    position: Float[np.ndarray, " 3"],
    target: ObjectInstance,
    size: Float[np.ndarray, " 3"],
    config: ViewpointsConfig,
    world: _World,
) -> bool:
    """Return whether the target is near the level of the camera and most of its sample points are in sight."""
    line = target.T_world_object[:3, 3] - position
    if abs(line[2]) > np.tan(np.deg2rad(config.max_elevation_deg)) * np.hypot(line[0], line[1]):
        return False
    points = transform_points(target.T_world_object, _sample_points(size))
    others = world.owners != target.instance_id
    hidden = world.solids.subset(others).block(position, points)
    return bool(np.mean(~hidden) >= _CLEAR_SHARE)


def _sample_points(size: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "9 3"]:
    """Return the centre of an object and eight points towards its corners, in its frame (m)."""
    return np.concatenate([np.zeros((1, 3)), 0.8 * box_corners(size)])
