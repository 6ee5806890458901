"""Is a scene physically possible? Answered from the boxes alone, without the physics engine that made it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import SceneSpec

_SEARCH = 0.03
"""Boxes further apart than this (m) are not looked at; a gap that large is reported as this."""
_UPRIGHT = 0.7
"""Least vertical share of the axis between two boxes for the lower one to carry the upper one."""


@dataclass(frozen=True, eq=False)
class ContactState:
    """How the objects of a scene touch; arrays over its loose objects and over touching pairs."""

    loose: Int[np.ndarray, " n"]
    """Instance ids of the loose objects."""
    gap: Float[np.ndarray, " n"]
    """Gap (m) between each of them and the nearest thing under it; negative when it sinks in."""
    pairs: Int[np.ndarray, "k 2"]
    """Instance ids of each two objects, one of them loose, that overlap."""
    overlap: Float[np.ndarray, " k"]
    """Depth of each overlap (m), > 0."""

    @property
    def max_gap(self) -> float:
        """The largest gap under a loose object (m), at least 0."""
        return max(0.0, float(self.gap.max(initial=0.0)))

    @property
    def max_overlap(self) -> float:
        """The depth of the deepest overlap (m), 0 when nothing overlaps."""
        return float(self.overlap.max(initial=0.0))


def contact_state(scene: SceneSpec) -> ContactState:
    """Test the collision boxes of ``scene`` against each other by the separating axis test."""
    owner, loose, stack = _world_boxes(scene)
    moving = np.flatnonzero(loose)
    pairs = stack.subset(loose).pairs(stack, _SEARCH)
    pairs[:, 0] = moving[pairs[:, 0]]
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    result = stack.separation(stack, pairs)
    upper, lower = owner[pairs[:, 0]], owner[pairs[:, 1]]

    ids = np.unique(owner[moving])
    gap = np.full(ids.size, _SEARCH)
    below = result.axis[:, 2] < -_UPRIGHT
    np.minimum.at(gap, np.searchsorted(ids, upper[below]), result.distance[below])

    deep = result.distance < 0.0
    touching = np.sort(np.stack([upper, lower], axis=1)[deep], axis=1)
    unique, which = np.unique(touching, axis=0, return_inverse=True)
    overlap = np.zeros(len(unique))
    np.maximum.at(overlap, which.reshape(-1), -result.distance[deep])
    return ContactState(ids, gap, unique, overlap)


def _world_boxes(scene: SceneSpec) -> tuple[Int[np.ndarray, " m"], Bool[np.ndarray, " m"], BoxStack]:
    """Return the owner of each collision box, whether it can move, and the boxes in the world."""
    rows = [
        (item.instance_id, item.dynamic, OrientedBox(item.T_world_object @ box.T_parent_box, box.size))
        for item in scene.instances
        for box in scene.model_of(item).collision
    ]
    owner = np.array([row[0] for row in rows], dtype=np.int64)
    loose = np.array([row[1] for row in rows], dtype=bool)
    return owner, loose, BoxStack.of([row[2] for row in rows])
