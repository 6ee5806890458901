"""Let a scene come to rest under gravity, stack by stack, and say whether it did.

With ``stability_check`` stacks need little or no simulation: what rests by construction is placed, what hangs together
moves as one. Goods that are proved to rest on their pallet (``scene.loads.resting``) are simulated with it as one body;
where the pallet, too, is proved to rest on what is under it, nothing is simulated. The rest is simulated piece by
piece.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics.check import SettleReport, contact_state
from warehouse_sim.physics.impulses import ImpulseConfig, impulse_loads
from warehouse_sim.physics.rest import Rest, RestLimits, Stack, boxes_around, bring_to_rest, find_stacks
from warehouse_sim.ranges import Range, ranged
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


_REACH = (0.03, 0.03, 0.06)
"""How far around a stack (m, along each axis) the fixed things are that it may touch while it settles."""

REST_SPEED, _REST_TURN = 0.002, 0.01
"""At rest every body is slower than the first (m/s) and turns slower than the second (rad/s)."""
MAX_OVERLAP_MM, MAX_GAP_MM = 1.0, 1.0
"""Deepest overlap, and largest gap under a loose object, of a scene that stands (mm)."""
_SHIFT, _FALL = 0.02, 0.25
"""A struck piece that ends further than the first from its place was pushed aside (m), than the second has fallen."""
_LIE = np.deg2rad(60.0)
"""So has one that is tilted further than this (rad)."""


@dataclass(frozen=True)
@ranged
class SettleConfig:
    """When a scene is at rest, and how far it may have moved by then."""

    max_time: Annotated[float, Range(0.1, 60, "s")] = 3.0
    """Longest simulated time of a stack (s), 0.1-60."""
    max_drift_mm: Annotated[float, Range(0.001, 10_000, "mm")] = 30.0
    """Largest way allowed from first to last place (mm), 0.001-10,000."""
    max_tilt_deg: Annotated[float, Range(0.001, 180, "deg")] = 3.0
    """Largest tilt allowed against the first orientation (deg), 0.001-180; beyond it a body has toppled."""
    stability_check: bool = False
    """Whether what is proved to rest is placed and not simulated; what is sampled stays, poses differ by under 1 mm."""
    impulses: ImpulseConfig = field(default_factory=ImpulseConfig)
    """Loads that were run into: where leaning and fallen goods come from."""


def settle_scene(
    spec: SceneSpec, config: SettleConfig, reach: tuple[float, float, float] = _REACH
) -> tuple[SceneSpec, SettleReport]:
    """Let each stack of loose objects come to rest alone among what is fixed, then check the scene as a whole.

    Stacks keep clear of each other, so one that has come to rest is fixed for the next; the check tells if not.

    Args:
        spec: Not settled yet.
        config: When it is at rest.
        reach: How far around a stack (m, along each axis) the fixed things are that it may touch: as far as it falls.
    """
    solids = Solids.of(spec.instances, spec.models)
    limits = RestLimits(REST_SPEED, _REST_TURN, config.max_time)
    stacks = find_stacks(spec.instances, solids)
    poses: dict[int, Transform] = {}
    rests: list[Rest] = []
    bring = bring_stack_to_rest if config.stability_check else bring_to_rest
    for stack in stacks:
        rest = bring(spec, stack, boxes_around(solids, stack, reach), limits)
        solids = solids.moved(rest.moved(stack), spec.models)
        poses |= rest.poses
        rests.append(rest)
    at_rest = _moved(spec, poses)
    impulses = impulse_loads(at_rest, stacks, solids, limits, config.impulses)
    settled = replace(_moved(at_rest, impulses.poses), settled=True)
    rests += impulses.rests
    return settled, _report(spec, at_rest, settled, rests, len(stacks), impulses.groups, config)


def _moved(scene: SceneSpec, poses: dict[int, Transform]) -> SceneSpec:
    """Return the scene with new poses; what is part of a load but not loose (film, posts) follows its pallet."""
    way: dict[int, Transform] = {}
    for item in scene.instances:
        if item.instance_id in poses and item.group:
            # The first piece of a load is its pallet.
            way.setdefault(item.group, poses[item.instance_id] @ invert(item.T_world_object))
    instances = []
    for item in scene.instances:
        follows = item.group in way and not item.dynamic
        T_world_object = way[item.group] @ item.T_world_object if follows else item.T_world_object
        instances.append(replace(item, T_world_object=poses.get(item.instance_id, T_world_object)))
    return replace(scene, instances=tuple(instances))


def _report(
    spec: SceneSpec,
    at_rest: SceneSpec,
    settled: SceneSpec,
    rests: list[Rest],
    stacks: int,
    struck: tuple[int, ...],
    config: SettleConfig,
) -> SettleReport:
    ids, drift, tilt = _displacements(spec, at_rest)
    _, way, lean = _displacements(at_rest, settled)
    hit = np.isin([item.group for item in settled.instances if item.dynamic], struck)
    state = contact_state(settled)
    toppled = tilt > np.deg2rad(config.max_tilt_deg)
    fallen = hit & ((way > _FALL) | (lean > _LIE))
    leaning = hit & ~fallen & (lean > np.deg2rad(config.max_tilt_deg))
    shifted = hit & ~fallen & ~leaning & (way > _SHIFT)
    speed, turn = (max((getattr(rest, name) for rest in rests), default=0.0) for name in ("speed", "turn"))
    duration = max((rest.duration for rest in rests), default=0.0)
    problems = []
    if speed >= REST_SPEED or turn >= _REST_TURN:
        problems.append(f"still moving at {speed:.3f} m/s and {turn:.3f} rad/s after {duration:.1f} s")
    problems += [
        f"object {i} toppled by {np.rad2deg(a):.1f} deg" for i, a in zip(ids[toppled], tilt[toppled], strict=True)
    ]
    problems += [
        f"object {i} moved by {1000 * way:.1f} mm"
        for i, way in zip(ids, drift, strict=True)
        if 1000 * way > config.max_drift_mm
    ]
    problems += state.problems(MAX_OVERLAP_MM, MAX_GAP_MM)
    return SettleReport(
        scene_index=settled.scene_index,
        seed=settled.seed,
        stacks=stacks,
        duration=duration,
        max_speed=speed,
        max_drift=float(drift.max(initial=0.0)),
        max_tilt=float(tilt.max(initial=0.0)),
        max_overlap=state.max_overlap,
        max_gap=state.max_gap,
        lowest=state.lowest,
        toppled=_as_ids(ids, toppled),
        struck=struck,
        shifted=_as_ids(ids, shifted),
        leaning=_as_ids(ids, leaning),
        fallen=_as_ids(ids, fallen),
        problems=tuple(problems),
    )


def _as_ids(ids: Int[np.ndarray, " n"], chosen: Bool[np.ndarray, " n"]) -> tuple[int, ...]:
    return tuple(int(i) for i in ids[chosen])


def _displacements(
    before: SceneSpec, after: SceneSpec
) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return ids of the loose objects, how far each moved (m) and by how much its z axis tilted (rad)."""
    loose = [item.dynamic for item in before.instances]
    ids = np.array([item.instance_id for item in before.instances], dtype=np.int64)[loose]
    T_before = np.array([item.T_world_object for item in before.instances])[loose]
    T_after = np.array([item.T_world_object for item in after.instances])[loose]
    drift = np.linalg.norm(T_after[:, :3, 3] - T_before[:, :3, 3], axis=1)
    # arctan2 keeps its digits near zero, where arccos of the dot product loses them.
    sine = np.linalg.norm(np.cross(T_before[:, :3, 2], T_after[:, :3, 2]), axis=1)
    cosine = np.einsum("ni,ni->n", T_before[:, :3, 2], T_after[:, :3, 2])
    return ids, drift, np.arctan2(sine, cosine)
