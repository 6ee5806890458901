"""What a truck meets: the pallet that it takes, what stands on it, and what stands around."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.evaluation.docking.fork import DockingFace, docking_faces
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.physics.rest import find_stacks
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, SceneSpec

_AROUND = (1.8, 1.8, 0.8)
"""How far around the pallet (m, along each axis) other things are kept: tines, carriage and load come no farther."""
_ON_TOP = 0.03
"""What begins at most this far below the top of the pallet (m) stands on it."""


@dataclass(frozen=True, eq=False)
class Station:
    """A pallet with its load among fixed things."""

    scene: SceneSpec
    pallet: ObjectInstance
    load: tuple[ObjectInstance, ...]
    """What stands on the pallet or is part of its load; it moves as one body."""
    around: tuple[OrientedBox, ...]
    """Boxes of everything else nearby, in the world."""
    surroundings: Solids
    """Boxes of everything in the scene but the pallet and its load."""

    @property
    def faces(self) -> tuple[DockingFace, ...]:
        """Sides of the pallet that can be approached."""
        model = self.scene.model_of(self.pallet)
        return docking_faces(model.size, model.pockets)

    def face(self, name: str) -> DockingFace:
        """Return the side called ``name``, "-x", ..."""
        return next(face for face in self.faces if face.name == name)

    @property
    def carries_pallets(self) -> bool:
        """Whether another pallet stands on it."""
        return any(self.scene.model_of(item).pockets for item in self.load)


def station_of(scene: SceneSpec, instance_id: int, solids: Solids | None = None) -> Station:
    """Return the surroundings of a pallet of a settled scene.

    Args:
        scene: The scene at rest.
        instance_id: The pallet.
        solids: ``Solids.of`` the scene, where they are there already.
    """
    solids = solids or Solids.of(scene.instances, scene.models)
    pallet = next(item for item in scene.instances if item.instance_id == instance_id)
    load = _load(scene, pallet, solids)
    own = [pallet.instance_id, *(item.instance_id for item in load)]
    others = solids.subset(~solids.of_objects(own))
    near = others.near(*solids.extent_of([pallet.instance_id]), _AROUND)
    return Station(scene, pallet, load, tuple(others.listed(near)), others)


def _load(scene: SceneSpec, pallet: ObjectInstance, solids: Solids) -> tuple[ObjectInstance, ...]:
    """Return what the pallet bears, through whatever is between, and what is bound to it (film, posts)."""
    (_, top) = solids.extent_of([pallet.instance_id])
    stacks = find_stacks(scene.instances, solids)
    mine = next((stack for stack in stacks if any(item is pallet for item in stack)), ())
    found = [item for item in mine if item is not pallet and _lowest(item, solids) > top[2] - _ON_TOP]
    groups = {item.group for item in (pallet, *found)} - {0}
    found += [item for item in scene.instances if not item.dynamic and item.group in groups]
    return tuple(sorted(found, key=lambda item: item.instance_id))


def _lowest(item: ObjectInstance, solids: Solids) -> float:
    mine = solids.of_objects([item.instance_id])
    return float(solids.extents[0][mine, 2].min()) if np.any(mine) else np.inf
