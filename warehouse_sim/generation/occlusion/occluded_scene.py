"""A scene while occluders are added to it: what its cameras see now, and what one more occluder would change."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.annotate.occluders import KINDS as OCCLUDERS
from warehouse_sim.annotate.occluders import kinds_by_id
from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.generation.occlusion.occluder import Occluder, caster_of
from warehouse_sim.generation.occlusion.sight import Sight, cast_in_frame, look_at
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.viewpoints.free_space import UNDERFOOT, FreeSpace
from warehouse_sim.schema import ObjectInstance, SceneSpec

BEYOND = 0.2
"""How far something may stand out over the aisle's edge (m), where there is space."""
_MARGIN = 0.05
"""How far parts of an object may stand out of its collision boxes (m)."""


@dataclass(frozen=True, eq=False)
class Placed:
    """An occluder that stands in the scene."""

    occluder: Occluder
    T_world_occluder: Transform
    instance_ids: tuple[int, ...]


class OccludedScene:
    """The scene, rays against it and what is solid in its aisle, all up to date.

    Args:
        scene: The scene at rest.
        raycaster: Of that scene.
        camera: With which intrinsics it is seen.
        area: The aisle.
        clearance: Cameras are never nearer than this to anything (m), nor occluders.
    """

    def __init__(
        self, scene: SceneSpec, raycaster: RayCaster, camera: PinholeCamera, area: Area, clearance: float
    ) -> None:
        self.scene = scene
        self.camera = camera
        self.area = area
        self.solids = _in_reach(Solids.of(scene.instances, scene.models), area, clearance)
        self.targets = tuple(scene.target_instances())
        self.placed: list[Placed] = []
        self.instance_of = {item.instance_id: item for item in scene.instances}
        self._kinds = kinds_by_id(scene)
        self._raycaster = raycaster
        self._alone: dict[str, RayCaster] = {}

    def look(self, target: int, T_world_camera: Transform, rays: int) -> Sight | None:
        """Return the sight of an object, given by instance id, with all that was added; None when it has none."""
        item = self.instance_of[target]
        model = self.scene.model_of(item)
        sight = look_at(item, model.size, self._caster_alone(item), self.camera, T_world_camera, self._raycaster, rays)
        if sight is None:
            return None
        for placed in self.placed:
            sight = behind(sight, placed)
        return sight

    def main_kind(self, sight: Sight) -> str:
        """Return which kind of thing hides most of the target; "none" when nothing does."""
        counts = np.bincount(self._kinds[sight.first[sight.in_image & ~sight.seen]], minlength=len(OCCLUDERS))
        counts[OCCLUDERS.index("border")] = np.count_nonzero(~sight.in_image)
        return OCCLUDERS[int(np.argmax(counts))] if counts.any() else "none"

    def add(self, occluder: Occluder, T_world_occluder: Transform) -> Placed:
        """Put an occluder into the scene."""
        groups = max((item.group for item in self.scene.instances), default=0)
        new = tuple(occluder.placed(T_world_occluder, max(self.instance_of, default=0) + 1, groups))
        models = self.scene.models | dict(occluder.models)
        paints = materials_of(occluder.models.values())
        painted = {name: paints[name] for name in sorted(paints.keys() - self.scene.materials.keys())}
        self.scene = replace(
            self.scene,
            models=models,
            materials=self.scene.materials | painted,
            instances=(*self.scene.instances, *new),
        )
        self.instance_of |= {item.instance_id: item for item in new}
        self._kinds = kinds_by_id(self.scene)
        self.solids = self.solids.joined(Solids.of(new, models))
        self.placed.append(Placed(occluder, T_world_occluder, tuple(item.instance_id for item in new)))
        return self.placed[-1]

    def space(self) -> FreeSpace:
        """Return what views are checked against; what was added is no target."""
        return FreeSpace(self.solids, self.area, self.scene.models, self.targets)

    def is_beside_added(self, box: OrientedBox, reach: float) -> bool:
        """Return whether something that was added comes within ``reach`` (m) of the axis-parallel box about ``box``."""
        added = [number for placed in self.placed for number in placed.instance_ids]
        return bool((self.solids.near_box(box, reach) & self.solids.of_objects(added)).any())

    def takes(self, box: OrientedBox, clearance: float) -> bool:
        """Return whether ``box`` (world) lies over the aisle, at least ``clearance`` (m) from every solid."""
        over_aisle = all(self.area.contains(at, -BEYOND) for at in box.corners())
        return over_aisle and self.solids.gap(box, clearance) >= clearance

    def _caster_alone(self, item: ObjectInstance) -> RayCaster:
        """Return the caster of one object in its own frame."""
        if item.model not in self._alone:
            lone = ObjectInstance(1, item.model, np.eye(4))
            model = self.scene.models[item.model]
            self._alone[item.model] = caster_of({item.model: model}, (lone,), self.scene.materials)
        return self._alone[item.model]


def _in_reach(solids: Solids, area: Area, clearance: float) -> Solids:
    """Return the solids that something in the aisle ``area`` may come within ``clearance`` (m) of."""
    low, high = solids.extents
    near = (high[:, 0] > area.x_min - clearance) & (low[:, 0] < area.x_max + clearance)
    near &= (high[:, 1] > area.y_min - clearance) & (low[:, 1] < area.y_max + clearance)
    return solids.subset(near & (high[:, 2] > UNDERFOOT))


def behind(sight: Sight, placed: Placed) -> Sight:
    """Return the sight after an occluder was put into the scene."""
    middle = placed.occluder.envelope.placed(placed.T_world_occluder).T_parent_box[:3, 3]
    if not sight.passes(middle, float(np.linalg.norm(placed.occluder.envelope.size)) / 2 + _MARGIN):
        return sight
    hits = cast_in_frame(placed.occluder.caster, placed.T_world_occluder, sight.eye, sight.directions)
    return sight.behind(hits, np.array((0, *placed.instance_ids), np.int32))


def fraction_behind(sight: Sight, occluder: Occluder, T_world_occluder: Transform) -> float:
    """Return the visible fraction that an occluder would leave."""
    seen = sight.seen
    hits = cast_in_frame(occluder.caster, T_world_occluder, sight.eye, sight.directions[seen])
    return np.count_nonzero(hits.distance >= sight.reach[seen]) / max(len(sight.reach), 1)


def ground_line(sight: Sight, target: Float[np.ndarray, " 3"]) -> tuple[Float[np.ndarray, " 2"], float]:
    """Return the unit direction on the floor from the camera to ``target`` (m) and the distance (m)."""
    way = target[:2] - sight.eye[:2]
    length = float(np.linalg.norm(way))
    return way / length, length
