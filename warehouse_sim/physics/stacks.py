"""Which loose objects settle together: the pieces of a unit load, and loads that stand on each other."""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warehouse_sim.geometry.broad_phase import overlapping_pairs
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance

_SEAM = 0.03
"""A load stands on another when its bottom is within this of the other's top (m)."""

Stack = tuple[ObjectInstance, ...]
"""Loose objects that settle together."""


def find_stacks(instances: Iterable[ObjectInstance], solids: Solids) -> list[Stack]:
    """Return the loose ones of ``instances`` stack by stack, the lowest stack first, then by instance id."""
    loads = _loads(instances)
    if not loads:
        return []
    extents = [solids.extent_of([item.instance_id for item in load]) for load in loads]
    low, high = np.array([low for low, _ in extents]), np.array([high for _, high in extents])
    upper, lower = _standing_on(low, high).T
    touching = coo_array((np.ones(len(upper)), (upper, lower)), shape=(len(loads), len(loads)))
    _, stack_of = connected_components(touching, directed=False)
    stacks: dict[int, list[ObjectInstance]] = defaultdict(list)
    bottom: dict[int, float] = {}
    for index, (load, key) in enumerate(zip(loads, stack_of.tolist(), strict=True)):
        stacks[key] += load
        bottom[key] = min(bottom.get(key, np.inf), float(low[index, 2]))
    ordered = sorted(stacks, key=lambda key: (round(bottom[key], 3), stacks[key][0].instance_id))
    return [tuple(sorted(stacks[key], key=lambda item: item.instance_id)) for key in ordered]


def _loads(instances: Iterable[ObjectInstance]) -> list[list[ObjectInstance]]:
    """Return the loose objects by group; one without a group is a load of its own."""
    loads: dict[tuple[int, int], list[ObjectInstance]] = defaultdict(list)
    for item in instances:
        if item.dynamic:
            loads[(item.group, 0 if item.group else item.instance_id)].append(item)
    return list(loads.values())


def _standing_on(low: Float[np.ndarray, "n 3"], high: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "k 2"]:
    """Return rows (upper, lower) of loads that stand on each other."""
    foot = high.copy()
    foot[:, 2], sole = low[:, 2] + _SEAM, low - [0.0, 0.0, _SEAM]
    head = low.copy()
    head[:, 2] = high[:, 2]
    return overlapping_pairs(sole, foot, head, high)
