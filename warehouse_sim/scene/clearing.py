"""Loads that were put into something else: slid to the nearest free place, before physics pushes them apart."""

import logging
from collections import defaultdict
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, SceneSpec

_DEEP = 0.002
"""Boxes that overlap by less (m) are left to physics."""
_FARTHEST, _STEP = 1.0, 0.02
"""How far a load is slid at most, and in which steps (m)."""
_WAYS = 24
"""Directions that are tried."""

_log = logging.getLogger(__name__)


def cleared(scene: SceneSpec) -> SceneSpec:
    """Return the scene with each load that overlaps something else slid along the floor to where it does not.

    What is fixed stays; of two loads the one that was added later gives way. A warning says what was moved.

    Raises:
        PlacementError: A load has no free place within a metre.
    """
    loads: dict[int, list[ObjectInstance]] = defaultdict(list)
    for item in scene.instances:
        if item.dynamic:
            loads[item.group or -item.instance_id].append(item)
    solids, ways = Solids.of(scene.instances, scene.models), _ways()
    waiting = {item.instance_id for load in loads.values() for item in load}
    moved: dict[int, ObjectInstance] = {}
    for load in loads.values():
        mine = Solids.of(load, scene.models)
        waiting -= {item.instance_id for item in load}
        others = ~solids.of_objects([*waiting, *(item.instance_id for item in load)])
        low, high = solids.extent_of([item.instance_id for item in load])
        around = solids.boxes.subset(others & solids.near(low, high, _FARTHEST))
        way = next((way for way in ways if _is_clear(mine.boxes, way, around)), None)
        if way is None:
            raise PlacementError(
                f"{load[0].model} (object {load[0].instance_id}) at {_place(load[0])} m overlaps what stands there, "
                f"and has no free place within {_FARTHEST:g} m; put it elsewhere"
            )
        if way.any():
            _log.warning(
                "%s (object %d) at %s m overlapped what stands there; it was moved by %.2f m",
                load[0].model, load[0].instance_id, _place(load[0]), float(np.hypot(way[0], way[1])),
            )  # fmt: skip
            there = [_shifted(item, way) for item in load]
            solids = solids.moved(there, scene.models)
            moved |= {item.instance_id: item for item in there}
    return replace(scene, instances=tuple(moved.get(item.instance_id, item) for item in scene.instances))


def _ways() -> list[Float[np.ndarray, " 3"]]:
    """Return the ways to try, the shortest first."""
    angles = 2.0 * np.pi * np.arange(_WAYS) / _WAYS
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(_WAYS)], axis=1)
    lengths = np.arange(_STEP, _FARTHEST + _STEP / 2, _STEP)
    return [np.zeros(3), *(length * way for length in lengths for way in circle)]


def _is_clear(boxes: BoxStack, way: Float[np.ndarray, " 3"], others: BoxStack) -> bool:
    """Return whether boxes that are slid a way overlap none of the others by more than physics closes."""
    there = BoxStack(boxes.centre + way, boxes.rotation, boxes.half)
    pairs = there.pairs(others, 0.0)
    return bool(np.min(there.separation(others, pairs).distance, initial=np.inf) > -_DEEP)


def _shifted(item: ObjectInstance, way: Float[np.ndarray, " 3"]) -> ObjectInstance:
    return replace(item, T_world_object=make_transform(translation=way) @ item.T_world_object)


def _place(item: ObjectInstance) -> str:
    return ", ".join(f"{value:.2f}" for value in item.T_world_object[:3, 3])
