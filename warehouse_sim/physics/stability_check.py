"""Stacks that need little or no simulation: what rests by construction is placed, what hangs together moves as one.

Goods that are proved to rest on their pallet (``scene.loads.resting``) are simulated with it as one body; where the
pallet, too, is proved to rest on what is under it, nothing is simulated. The rest of a stack is simulated piece by
piece.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics.rest import Rest, RestLimits, bring_to_rest
from warehouse_sim.physics.stacks import Stack
from warehouse_sim.scene.loads.resting import drop_to_rest, joined, proved_load
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, SceneSpec

Block = list[ObjectInstance]
"""The pallet and the goods of a load, at the poses in which they rest on each other."""


def bring_stack_to_rest(scene: SceneSpec, stack: Stack, solids: Sequence[OrientedBox], limits: RestLimits) -> Rest:
    """Let a stack come to rest among fixed ``solids``, with no more simulation than its checks leave."""
    blocks: list[Block] = []
    loose: list[ObjectInstance] = []
    for _, members in groupby(stack, key=lambda item: item.group or -item.instance_id):
        load = list(members)
        poses = proved_load([(scene.model_of(item), item.T_world_object) for item in load])
        if poses is None:
            loose += load
        else:
            blocks.append([replace(item, T_world_object=T) for item, T in zip(load, poses, strict=True)])
    placed = None if loose else _placed(scene, blocks, BoxStack.of(solids))
    if placed is not None:
        return Rest(placed, 0.0, 0.0, 0.0)
    return bring_to_rest(scene, loose, solids, limits, blocks=blocks)


def _placed(scene: SceneSpec, blocks: list[Block], below: BoxStack) -> dict[int, Transform] | None:
    """Lower loads onto what is ``below`` and onto each other; None where one is not sure to stand."""
    poses: dict[int, Transform] = {}
    boxes = [Solids.of(block, scene.models) for block in blocks]
    order = sorted(range(len(blocks)), key=lambda number: float(boxes[number].extents[0][:, 2].min()))
    for number in order:
        block, stack = blocks[number], boxes[number].boxes
        foot = boxes[number].subset(boxes[number].owner == block[0].instance_id).boxes
        drop = drop_to_rest(foot, below, _middle(scene, block))
        if drop is None:
            return None
        for item in block:
            poses[item.instance_id] = item.T_world_object.copy()
            poses[item.instance_id][2, 3] -= drop
        below = joined([below, BoxStack(stack.centre - [0.0, 0.0, drop], stack.rotation, stack.half)])
    return poses


def _middle(scene: SceneSpec, block: Block) -> np.ndarray:
    """Return x and y (m) of the centre of mass of a load, each piece's taken at its origin."""
    mass = np.array([scene.model_of(item).mass for item in block])
    return mass @ np.array([item.T_world_object[:2, 3] for item in block]) / mass.sum()
