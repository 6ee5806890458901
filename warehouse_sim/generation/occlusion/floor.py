"""Where in the aisle something can still be put, and where a camera still has room."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from jaxtyping import Int

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

BEYOND = 0.2
"""How far something may stand out over the aisle's edge (m), where there is room."""
_UNDERFOOT = 0.05
"""What ends below this height is in nobody's way (m)."""


class FreeFloor:
    """The aisle with all solids that stand in it or reach into it.

    Args:
        scene: What stands there.
        area: The aisle.
        room: Solids further than this from the aisle (m) are out of reach of everything in it.
    """

    def __init__(self, scene: SceneSpec, area: Area, room: float) -> None:
        self.area = area
        owners, stack = _solids(scene, scene.instances)
        low, high = stack.extents()
        near = (high[:, 0] > area.x_min - room) & (low[:, 0] < area.x_max + room)
        near &= (high[:, 1] > area.y_min - room) & (low[:, 1] < area.y_max + room)
        near &= high[:, 2] > _UNDERFOOT
        self._owners, self._solids = owners[near], stack.subset(near)
        self._low, self._high = low[near], high[near]

    def add(self, scene: SceneSpec, new: Iterable[ObjectInstance]) -> None:
        """Take the floor under new objects of ``scene``."""
        owners, more = _solids(scene, new)
        old, (low, high) = self._solids, more.extents()
        self._owners = np.concatenate([self._owners, owners])
        self._solids = BoxStack(
            np.concatenate([old.centre, more.centre]),
            np.concatenate([old.rotation, more.rotation]),
            np.concatenate([old.half, more.half]),
        )
        self._low, self._high = np.concatenate([self._low, low]), np.concatenate([self._high, high])

    def takes(self, box: OrientedBox, clearance: float) -> bool:
        """Return whether ``box`` (world) lies over the aisle, at least ``clearance`` (m) from every solid."""
        return all(self.area.contains(at, -BEYOND) for at in box.corners()) and self.gap(box, clearance) >= clearance

    def gap(self, box: OrientedBox, reach: float) -> float:
        """Return the distance (m) from ``box`` to the nearest solid, negative inside; infinite beyond ``reach``."""
        rows = self._close(box, reach)
        pairs = np.column_stack([np.arange(len(rows)), np.zeros(len(rows), int)])
        if not len(rows):
            return np.inf
        return float(self._solids.subset(rows).separation(BoxStack.of([box]), pairs).distance.min())

    def around(self, box: OrientedBox, reach: float) -> list[OrientedBox]:
        """Return the solids whose axis-parallel boxes come within ``reach`` (m) of that of ``box``."""
        return [
            OrientedBox(
                make_transform(self._solids.rotation[row], self._solids.centre[row]), 2 * self._solids.half[row]
            )
            for row in self._close(box, reach)
        ]

    def space(self, models: Mapping[str, ObjectModel], targets: tuple[ObjectInstance, ...]) -> FreeSpace:
        """Return the same solids as views of ``targets`` are checked against."""
        return FreeSpace(self._solids, self._owners, self.area, models, targets)

    def _close(self, box: OrientedBox, reach: float) -> Int[np.ndarray, " k"]:
        (low,), (high,) = BoxStack.of([box]).extents()
        return np.flatnonzero(((self._low <= high + reach) & (self._high >= low - reach)).all(axis=1))


def _solids(scene: SceneSpec, instances: Iterable[ObjectInstance]) -> tuple[Int[np.ndarray, " n"], BoxStack]:
    """Return the collision boxes of ``instances`` in the world and whose they are."""
    rows: Sequence[tuple[ObjectInstance, OrientedBox]] = [
        (item, OrientedBox(item.T_world_object @ box.T_parent_box, box.size))
        for item in instances
        for box in scene.model_of(item).collision
    ]
    return np.array([item.instance_id for item, _ in rows], dtype=int), BoxStack.of([box for _, box in rows])
