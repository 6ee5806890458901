"""Something that can be put into a scene to hide a target: a few objects at rest on a level floor."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warehouse_sim.catalog import materials_of
from warehouse_sim.catalog.building import FLOOR_SIZE
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.physics.settle import SettleConfig, settle_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec


@dataclass(frozen=True, eq=False)
class Occluder:
    """Objects in a frame of their own: on the floor under their middle, z up."""

    kind: str
    """What it was sampled as, one of ``config.KINDS``."""
    models: Mapping[str, ObjectModel]
    instances: tuple[ObjectInstance, ...]
    """Poses in the occluder's frame; instance ids are given again in a scene, groups count from 1."""

    @cached_property
    def caster(self) -> RayCaster:
        """Casts rays at it in its own frame."""
        return caster_of(self.models, self.instances, materials_of(self.models.values()))

    @cached_property
    def envelope(self) -> OrientedBox:
        """The box around it in its own frame."""
        lows, highs = Solids.of(self.instances, self.models).extents
        low, high = lows.min(axis=0), highs.max(axis=0)
        return OrientedBox(make_transform(translation=(low + high) / 2), high - low)

    @property
    def height(self) -> float:
        """Height over all (m)."""
        return float(self.envelope.T_parent_box[2, 3] + self.envelope.size[2] / 2)

    @property
    def radius(self) -> float:
        """Radius of its ground (m) about its middle."""
        corners = self.envelope.corners()[:, :2]
        return float(np.linalg.norm(corners, axis=1).max())

    def placed(self, T_world_occluder: Transform, first_id: int, groups: int) -> Iterator[ObjectInstance]:
        """Yield its objects in the world.

        Args:
            T_world_occluder: Where it stands.
            first_id: Instance id of the first of them.
            groups: Number of unit loads that the scene has already.
        """
        for number, item in enumerate(self.instances):
            yield replace(
                item,
                instance_id=first_id + number,
                T_world_object=T_world_occluder @ item.T_world_object,
                group=item.group + groups if item.group else 0,
            )


def at_rest(kind: str, draft: SceneDraft) -> Occluder | None:
    """Return what was drafted over the plane z = 0 as an occluder, after it has settled there; None if it falls."""
    draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -FLOOR_SIZE[2] / 2])))
    scene = SceneSpec(0, 0, draft.models, materials_of(draft.models.values()), tuple(draft.instances), (), ())
    settled, report = settle_scene(scene, SettleConfig())
    if report.problems:
        return None
    models = {item.model: draft.models[item.model] for item in settled.instances[:-1]}
    return Occluder(kind, models, settled.instances[:-1])


def caster_of(
    models: Mapping[str, ObjectModel], instances: Sequence[ObjectInstance], known: Mapping[str, Material]
) -> RayCaster:
    """Return a caster of some objects; ``known`` holds the materials of their parts."""
    return RayCaster(SceneSpec(0, 0, dict(models), dict(known), tuple(instances), (), ()))
