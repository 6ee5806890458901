"""What is solid in a scene: the collision boxes of its objects as arrays, and whose each is."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import ObjectInstance, ObjectModel


@dataclass(frozen=True, eq=False)
class Solids:
    """Collision boxes in the frame that their objects are placed in, the world for a scene."""

    owner: Int[np.ndarray, " n"]
    """Instance id of each box."""
    boxes: BoxStack

    @classmethod
    def of(cls, instances: Iterable[ObjectInstance], models: Mapping[str, ObjectModel]) -> "Solids":
        """Collect the boxes of ``instances`` in their order."""
        rows = [(item, box) for item in instances for box in models[item.model].collision]
        T_world_object = np.array([item.T_world_object for item, _ in rows]).reshape(-1, 4, 4)
        T = T_world_object @ np.array([box.T_parent_box for _, box in rows]).reshape(-1, 4, 4)
        sizes = np.array([box.size for _, box in rows], dtype=float).reshape(-1, 3)
        owner = np.array([item.instance_id for item, _ in rows], dtype=np.int64)
        return cls(owner, BoxStack(T[:, :3, 3], T[:, :3, :3], sizes / 2.0))

    @cached_property
    def extents(self) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
        """Lower and upper corners (m) of the axis-parallel boxes around each box."""
        return self.boxes.extents()

    def of_objects(self, ids: Collection[int]) -> Bool[np.ndarray, " n"]:
        """Return which boxes belong to objects with these instance ids."""
        return np.isin(self.owner, list(ids))

    def subset(self, chosen: Bool[np.ndarray, " n"]) -> "Solids":
        """Return the boxes for which ``chosen`` is set."""
        return Solids(self.owner[chosen], self.boxes.subset(chosen))

    def listed(self, chosen: Bool[np.ndarray, " n"]) -> list[OrientedBox]:
        """Return the boxes for which ``chosen`` is set, one by one."""
        stack = self.boxes
        return [
            OrientedBox(make_transform(stack.rotation[row], stack.centre[row]), 2 * stack.half[row])
            for row in np.flatnonzero(chosen)
        ]

    def joined(self, other: "Solids") -> "Solids":
        """Return these boxes, and after them those of ``other``."""
        one, two = self.boxes, other.boxes
        stack = BoxStack(
            np.concatenate([one.centre, two.centre]),
            np.concatenate([one.rotation, two.rotation]),
            np.concatenate([one.half, two.half]),
        )
        return Solids(np.concatenate([self.owner, other.owner]), stack)

    def moved(self, instances: Iterable[ObjectInstance], models: Mapping[str, ObjectModel]) -> "Solids":
        """Return the boxes with those of ``instances`` at their new poses."""
        new = Solids.of(instances, models)
        centre, rotation = self.boxes.centre.copy(), self.boxes.rotation.copy()
        # By owner, and of each in the order of its model's boxes: so these and the new ones are in one order.
        mine = np.flatnonzero(np.isin(self.owner, new.owner))
        mine = mine[np.argsort(self.owner[mine], kind="stable")]
        its = np.argsort(new.owner, kind="stable")
        centre[mine], rotation[mine] = new.boxes.centre[its], new.boxes.rotation[its]
        return Solids(self.owner, BoxStack(centre, rotation, self.boxes.half))

    def extent_of(self, ids: Collection[int]) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]:
        """Return the lower and upper corner (m) of the axis-parallel box around objects given by instance id."""
        mine, (low, high) = self.of_objects(ids), self.extents
        return low[mine].min(axis=0), high[mine].max(axis=0)

    def near(
        self, low: Float[np.ndarray, " 3"], high: Float[np.ndarray, " 3"], reach: float | Collection[float] = 0.0
    ) -> Bool[np.ndarray, " n"]:
        """Return which boxes come within ``reach`` (m, along each axis) of the axis-parallel box ``low``-``high``."""
        return self.boxes.near(low - reach, high + reach)

    def near_box(self, box: OrientedBox, reach: float) -> Bool[np.ndarray, " n"]:
        """Return which boxes come within ``reach`` (m) of the axis-parallel box around ``box``."""
        (low,), (high,) = BoxStack.of([box]).extents()
        return self.near(low, high, reach)

    def gap(self, box: OrientedBox, reach: float) -> float:
        """Return the distance (m) from ``box`` to the nearest solid, negative inside; infinite beyond ``reach``."""
        near = self.boxes.subset(self.near_box(box, reach))
        pairs = np.column_stack([np.arange(len(near.half)), np.zeros(len(near.half), int)])
        return float(np.min(near.separation(BoxStack.of([box]), pairs).distance, initial=np.inf))
