"""A scene while it is being put together: it hands out instance ids and remembers which models are in use."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import Transform
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
class SceneDraft:
    """Instances and models so far; ids count from 1 in the order of adding."""

    models: dict[str, ObjectModel] = field(default_factory=dict)
    instances: list[ObjectInstance] = field(default_factory=list)
    groups: int = 0
    """Number of unit loads so far."""

    def add(self, model: str | ObjectModel, T_world_object: Transform, group: int = 0) -> ObjectInstance:
        """Add an object by its catalog name or by itself; what belongs to a unit load can move, the rest is fixed."""
        found = catalog_object(model) if isinstance(model, str) else model
        if self.models.setdefault(found.name, found).obj_id != found.obj_id:
            raise ConfigError(f"two objects of the recipe are called {found.name!r}; give your own another name")
        instance = ObjectInstance(len(self.instances) + 1, found.name, T_world_object, dynamic=group > 0, group=group)
        self.instances.append(instance)
        return instance

    def new_group(self) -> int:
        """Return the number of a new unit load, >= 1."""
        self.groups += 1
        return self.groups

    def solids(self) -> Solids:
        """Return the collision boxes in the world of everything so far, in order of id."""
        return Solids.of(self.instances, self.models)
