"""Where a camera or a vehicle has room in a scene, and how much of a target is in sight from there."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox, box_corners
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.loads.backdrop import is_backdrop
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec, Viewpoint

_EDGE = 0.3
"""Least distance from the camera to the aisle's edge (m)."""
_ABOVE_FLOOR = 0.1
"""Least height of a camera (m)."""
_BODY_CLEARANCE = 0.08
"""Least distance from a vehicle to any object (m)."""
_ROUNDING = 1e-6
"""Boxes that are this much farther than asked (m) are still measured, so that rounding decides nothing."""
UNDERFOOT = 0.05
"""What ends below this height (m) is driven over."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The solid boxes of a scene, its aisle and its targets."""

    solids: Solids
    """Collision boxes in the world."""
    area: Area
    """Floor that cameras stay over."""
    models: Mapping[str, ObjectModel]
    targets: tuple[ObjectInstance, ...]
    """What can be aimed at."""

    @classmethod
    def of(
        cls,
        instances: Iterable[ObjectInstance],
        models: Mapping[str, ObjectModel],
        targets: Sequence[str],
        area: Area,
    ) -> "FreeSpace":
        """Collect the boxes of ``instances``; those whose class is among ``targets`` can be aimed at.

        Raises:
            PlacementError: There is no target.
        """
        instances = list(instances)
        chosen = tuple(item for item in instances if models[item.model].class_name in targets and not is_backdrop(item))
        if not chosen:
            raise PlacementError(f"no object of the scene is of a target class ({', '.join(targets)})")
        return cls(Solids.of(instances, models), area, models, chosen)

    @classmethod
    def of_scene(cls, scene: SceneSpec) -> "FreeSpace":
        """Collect the boxes of a scene as it stands.

        Raises:
            PlacementError: There is no target, or the scene does not say where its aisle is.
        """
        if scene.aisle is None:
            raise PlacementError(f"scene {scene.scene_index} of seed {scene.seed} does not say where its aisle is")
        return cls.of(scene.instances, scene.models, scene.targets, Area(*scene.aisle))

    def is_clear(self, viewpoint: Viewpoint, clearance: float, lift: float | None = 0.0) -> bool:
        """Return whether a camera and the vehicle that carries it are clear of all objects.

        Args:
            viewpoint: Where they are.
            clearance: Least distance from the camera to any object (m).
            lift: How far the forks are raised (m); None where that is not known: then the camera alone counts.
        """
        if not self.admits_camera(viewpoint.T_world_camera[:3, 3], clearance):
            return False
        return lift is None or self.admits_bodies(vehicle_boxes(viewpoint, lift))

    def admits_camera(self, position: Float[np.ndarray, " 3"], clearance: float) -> bool:
        """Return whether ``position`` (m) is over the aisle and ``clearance`` (m) from every object but the floor."""
        if not self.area.contains(position, margin=_EDGE) or position[2] < _ABOVE_FLOOR:
            return False
        reach = clearance + _ROUNDING
        close = self._standing.subset(self._standing.near(position - reach, position + reach))
        return bool(np.min(close.distances_to(position), initial=np.inf) >= clearance)

    def admits_bodies(self, boxes: Sequence[OrientedBox]) -> bool:
        """Return whether none of a vehicle's ``boxes`` touches an object or comes near one."""
        bodies = BoxStack.of(boxes)
        pairs = bodies.pairs(self._obstacles, _BODY_CLEARANCE)
        distance = bodies.separation(self._obstacles, pairs).distance
        return bool(np.min(distance, initial=np.inf) >= _BODY_CLEARANCE)

    def sight_fraction(self, eye: Float[np.ndarray, " 3"], target: ObjectInstance) -> float:
        """Return the fraction of a target's nine sample points that no other object's box hides from ``eye`` (m)."""
        points = transform_points(target.T_world_object, _sample_points(self.models[target.model].size))
        ends = np.vstack([eye, points])
        between = self.solids.near(ends.min(axis=0), ends.max(axis=0)) & (self.solids.owner != target.instance_id)
        hidden = self.solids.boxes.subset(between).block(eye, points)
        return float(np.mean(~hidden))

    def shuffled_targets(self, aisle_fraction: float, rng: np.random.Generator) -> list[ObjectInstance]:
        """Return the targets in random order: those in the aisle first with probability ``aisle_fraction``."""
        wanted = rng.random() < aisle_fraction
        shuffled = [self.targets[index] for index in rng.permutation(len(self.targets))]
        return sorted(shuffled, key=lambda item: self.in_aisle(item) != wanted)

    def in_aisle(self, target: ObjectInstance) -> bool:
        """Return whether ``target`` stands in the aisle and not beside it."""
        return self.area.contains(target.T_world_object[:3, 3])

    @cached_property
    def target_centres(self) -> Float[np.ndarray, "n 3"]:
        """Centres of the targets in the world (m)."""
        return np.array([item.T_world_object[:3, 3] for item in self.targets])

    @cached_property
    def _standing(self) -> BoxStack:
        """All but the floor, which may be nearer: only what stands on it limits a camera."""
        return self.solids.boxes.subset(self.solids.boxes.centre[:, 2] > 0.0)

    @cached_property
    def _obstacles(self) -> BoxStack:
        return self.solids.boxes.subset(self.solids.extents[1][:, 2] > UNDERFOOT)


def vehicle_boxes(viewpoint: Viewpoint, lift: float = 0.0) -> Sequence[OrientedBox]:
    """Return the boxes (world) of what carries a camera, forks raised by ``lift`` (m); none where nothing does."""
    mounting = MOUNTINGS.get(viewpoint.kind)
    if mounting is None or mounting.vehicle is None or viewpoint.T_world_vehicle is None:
        return ()
    return mounting.vehicle.boxes(viewpoint.T_world_vehicle, lift)


def keeps_clear(box: OrientedBox, viewpoints: Iterable[Viewpoint], clearance: float) -> bool:
    """Return whether ``box`` (world) is ``clearance`` (m) from every camera and does not touch what carries it."""
    single = BoxStack.of([box])
    return all(
        single.distances_to(viewpoint.T_world_camera[:3, 3])[0] >= clearance
        and BoxStack.of(vehicle_boxes(viewpoint)).clear_of(box, _BODY_CLEARANCE)
        for viewpoint in viewpoints
    )


def _sample_points(size: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "9 3"]:
    """Return the centre of an object and eight points towards its corners, in its frame (m)."""
    return np.concatenate([np.zeros((1, 3)), 0.8 * box_corners(size)])
