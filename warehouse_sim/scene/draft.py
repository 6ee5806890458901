"""A scene while it is being put together: it hands out instance ids and remembers which models are in use."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, ObjectModel

HALF_TURN = np.diag([-1.0, -1.0, 1.0])
QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Rotations about the vertical."""


@dataclass(frozen=True)
class Area:
    """An axis-parallel rectangle of floor (m)."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    def contains(self, point: Float[np.ndarray, "..."], margin: float = 0.0) -> bool:
        """Return whether ``point`` is over the rectangle, at least ``margin`` from its edges (m)."""
        x, y = point[0], point[1]
        in_x = self.x_min + margin <= x <= self.x_max - margin
        return bool(in_x and self.y_min + margin <= y <= self.y_max - margin)


@dataclass
class Crowd:
    """What is in the way of things that are put down one after the other, and those that were."""

    there: BoxStack
    placed: list[OrientedBox] = field(default_factory=list)

    def takes(self, boxes: Sequence[OrientedBox], clearance: float) -> bool:
        """Return whether ``boxes`` keep ``clearance`` (m) from all there is; if so, they are there from now on."""
        others = (self.there, BoxStack.of(self.placed))
        if not all(stack.clear_of(box, clearance) for stack in others for box in boxes):
            return False
        self.placed += boxes
        return True


@dataclass
class SceneDraft:
    """Instances and models so far; ids count from 1 in the order of adding."""

    models: dict[str, ObjectModel] = field(default_factory=dict)
    instances: list[ObjectInstance] = field(default_factory=list)
    groups: int = 0
    """Number of unit loads so far."""

    def add(
        self, model: str | ObjectModel, T_world_object: Transform, group: int = 0, *, fixed: bool = False
    ) -> ObjectInstance:
        """Add an object by its catalog name or by itself; what belongs to a load moves unless it is ``fixed``."""
        found = catalog_object(model) if isinstance(model, str) else model
        if self.models.setdefault(found.name, found).obj_id != found.obj_id:
            raise ConfigError(f"two objects of the recipe are called {found.name!r}; give your own another name")
        moves = group > 0 and not fixed
        instance = ObjectInstance(len(self.instances) + 1, found.name, T_world_object, dynamic=moves, group=group)
        self.instances.append(instance)
        return instance

    def put(
        self,
        model: str | ObjectModel,
        at: Sequence[float],
        T_world_frame: Transform | None = None,
        rotation: Float[np.ndarray, "3 3"] | None = None,
    ) -> ObjectInstance:
        """Add a fixed object whose middle is ``at`` x, y and z (m) of a frame, the world's by default."""
        T_frame_object = make_transform(rotation, np.array(at, dtype=float))
        return self.add(model, T_frame_object if T_world_frame is None else T_world_frame @ T_frame_object)

    def forget_unused(self) -> None:
        """Drop the models that no instance is of any more."""
        used = {item.model for item in self.instances}
        self.models = {name: model for name, model in self.models.items() if name in used}

    def new_group(self) -> int:
        """Return the number of a new unit load, >= 1."""
        self.groups += 1
        return self.groups

    def solids(self) -> Solids:
        """Return the collision boxes in the world of everything so far, in order of id."""
        return Solids.of(self.instances, self.models)

    def crowd(self, above: float = -np.inf, below: float = np.inf) -> Crowd:
        """Return what ends above and begins below these heights (m) so far."""
        solids = self.solids()
        low, high = solids.extents
        return Crowd(solids.boxes.subset((high[:, 2] > above) & (low[:, 2] < below)))
