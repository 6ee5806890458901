"""Everything solid in a scene as boxes in the world, kept up to date while one load after the other comes to rest."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, Transforms
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The collision boxes of a scene; ``move`` changes them in place."""

    owner: Int[np.ndarray, " n"]
    """Instance id of each box."""
    loose: Bool[np.ndarray, " n"]
    """Whether its owner can move."""
    T_object_box: Transforms
    """Each box in its object."""
    T_world_box: Transforms
    """Each box in the world."""
    size: Float[np.ndarray, "n 3"]
    """Edge lengths (m)."""
    low: Float[np.ndarray, "n 3"]
    """Lower corners of the axis-parallel boxes around them (m)."""
    high: Float[np.ndarray, "n 3"]
    """Upper corners (m)."""

    @classmethod
    def of(cls, scene: SceneSpec) -> "Surroundings":
        """Collect the boxes of ``scene`` in order of its instances."""
        rows = [(item, box) for item in scene.instances for box in scene.model_of(item).collision]
        T_world_object = np.array([item.T_world_object for item, _ in rows]).reshape(-1, 4, 4)
        T_object_box = np.array([box.T_parent_box for _, box in rows]).reshape(-1, 4, 4)
        size = np.array([box.size for _, box in rows], dtype=float).reshape(-1, 3)
        T_world_box = T_world_object @ T_object_box
        low, high = _extents(T_world_box, size)
        return cls(
            owner=np.array([item.instance_id for item, _ in rows], dtype=np.int64),
            loose=np.array([item.dynamic for item, _ in rows], dtype=bool),
            T_object_box=T_object_box,
            T_world_box=T_world_box,
            size=size,
            low=low,
            high=high,
        )

    def stack(self) -> BoxStack:
        """Return all boxes for the separating axis test."""
        return BoxStack(self.T_world_box[:, :3, 3], self.T_world_box[:, :3, :3], self.size / 2)

    def move(self, poses: dict[int, Transform]) -> None:
        """Put objects, given by instance id, to new poses."""
        for instance_id, T_world_object in poses.items():
            mine = self.owner == instance_id
            self.T_world_box[mine] = T_world_object @ self.T_object_box[mine]
            self.low[mine], self.high[mine] = _extents(self.T_world_box[mine], self.size[mine])

    def extent_of(self, members: Sequence[int]) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]:
        """Return the lower and upper corner (m) of the axis-parallel box around ``members``, given by instance id."""
        mine = np.isin(self.owner, members)
        return self.low[mine].min(axis=0), self.high[mine].max(axis=0)

    def around(self, members: Sequence[int], reach: Sequence[float]) -> list[OrientedBox]:
        """Return the boxes of all other objects within ``reach`` (m along each axis) of the box around ``members``."""
        low, high = self.extent_of(members)
        others = ~np.isin(self.owner, members)
        near = others & (self.low <= high + reach).all(axis=1) & (self.high >= low - reach).all(axis=1)
        return [OrientedBox(self.T_world_box[row], self.size[row]) for row in np.flatnonzero(near)]


def _extents(
    T: Transforms, size: Float[np.ndarray, "n 3"]
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    return BoxStack(T[:, :3, 3], T[:, :3, :3], size / 2).extents()
