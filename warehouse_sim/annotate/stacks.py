"""Which pallets stand in stacks: on another pallet, or under one, with or without goods between them."""

from collections import defaultdict

import numpy as np

from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import SceneSpec

_CONTACT = 0.02
"""Boxes this near (m) touch; settled loads have smaller gaps, racks leave larger ones."""
_UPRIGHT = 0.7
"""Least vertical fraction of the axis between two boxes for the lower one to carry the upper one."""


def stacked_pallets(scene: SceneSpec, solids: Solids) -> tuple[set[int], set[int]]:
    """Return the instance ids of the pallets on which another pallet stands, and of those that stand on another.

    Args:
        scene: The settled scene.
        solids: Its collision boxes.
    """
    goods = {item.instance_id for item in scene.instances if item.group > 0}
    pallets = {item.instance_id for item in scene.instances if scene.model_of(item).class_name == "pallet"} & goods
    carried = _carried_by(solids.subset(solids.of_objects(goods)))
    under: set[int] = set()
    upon: set[int] = set()
    for bottom in pallets:
        reached: set[int] = set()
        front = {bottom}
        while front:
            front = {upper for lower in front for upper in carried[lower]} - reached
            reached |= front
        above = (reached & pallets) - {bottom}
        if above:
            under.add(bottom)
            upon |= above
    return under, upon


def _carried_by(solids: Solids) -> dict[int, set[int]]:
    """Return what stands directly on each object, by instance id."""
    stack, owner = solids.boxes, solids.owner
    pairs = stack.pairs(stack, _CONTACT)
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    result = stack.separation(stack, pairs)
    rests = (result.axis[:, 2] > _UPRIGHT) & (result.distance < _CONTACT)
    carried: dict[int, set[int]] = defaultdict(set)
    for lower, upper in np.unique(owner[pairs[rests]], axis=0).tolist():
        carried[lower].add(upper)
    return carried
