"""Loose objects under gravity until they rest, in a MuJoCo model of their own; which of them settle together.

Those are the pieces of a unit load, and loads that stand on each other.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, invert, make_transform, matrix_from_quat_wxyz
from warehouse_sim.geometry.separation import overlapping_pairs
from warehouse_sim.physics.build import to_mjspec
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, SceneSpec

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


_CHECK_EVERY = 10
"""Steps between two looks at the speeds; two quiet looks in a row are rest, as a turning point has no speed either."""

Blow = Callable[[mujoco.MjModel, mujoco.MjData], None]
"""Changes the velocities of a model that is about to be simulated."""


@dataclass(frozen=True)
class RestLimits:
    """When objects count as resting."""

    speed: float
    """Every body is slower than this (m/s)."""
    turn: float
    """Every body turns slower than this (rad/s)."""
    time: float
    """Longest simulated time (s)."""


@dataclass(frozen=True, eq=False)
class Rest:
    """Where objects came to rest, and whether they did."""

    poses: dict[int, Transform]
    """T_world_object by instance id."""
    duration: float
    """Simulated time (s)."""
    speed: float
    """Largest speed at the end (m/s)."""
    turn: float
    """Largest angular speed at the end (rad/s)."""

    def moved(self, members: Iterable[ObjectInstance]) -> list[ObjectInstance]:
        """Return ``members`` where they came to rest."""
        return [replace(item, T_world_object=self.poses[item.instance_id]) for item in members]

    def within(self, limits: RestLimits) -> bool:
        """Return whether everything rests."""
        return self.speed < limits.speed and self.turn < limits.turn


def boxes_around(solids: Solids, members: Sequence[ObjectInstance], reach: Sequence[float]) -> list[OrientedBox]:
    """Return the boxes of all other objects within ``reach`` (m along each axis) of the box around ``members``."""
    ids = [item.instance_id for item in members]
    return solids.listed(solids.near(*solids.extent_of(ids), reach) & ~solids.of_objects(ids))


def bring_to_rest(
    scene: SceneSpec,
    members: Sequence[ObjectInstance],
    solids: Sequence[OrientedBox],
    limits: RestLimits,
    blow: Blow | None = None,
    blocks: Sequence[Sequence[ObjectInstance]] = (),
) -> Rest:
    """Simulate ``members`` of ``scene`` among fixed ``solids`` until they rest or time is up.

    Args:
        scene: Where the models come from.
        members: Loose objects at their starting poses.
        solids: Fixed boxes in the world that they may touch.
        limits: What counts as rest.
        blow: Applied at the start.
        blocks: More objects, of which those of each block move as one body.
    """
    model = to_mjspec(scene, members, solids, blocks).compile()
    data = mujoco.MjData(model)
    if blow is not None:
        blow(model, data)
    quiet = 0
    while quiet < 2 and data.time < limits.time:
        mujoco.mj_step(model, data, nstep=_CHECK_EVERY)
        speed, turn = _speeds(data)
        quiet = quiet + 1 if speed < limits.speed and turn < limits.turn else 0
    poses = {item.instance_id: _pose(model, data, item) for item in members}
    for block in blocks:
        way = _pose(model, data, block[0]) @ invert(block[0].T_world_object)
        poses |= {item.instance_id: way @ item.T_world_object for item in block}
    return Rest(poses, float(data.time), *_speeds(data))


def _pose(model: mujoco.MjModel, data: mujoco.MjData, item: ObjectInstance) -> Transform:
    qpos = data.joint(model.body(str(item.instance_id)).jntadr[0]).qpos
    return make_transform(matrix_from_quat_wxyz(qpos[3:]), qpos[:3].copy())


def _speeds(data: mujoco.MjData) -> tuple[float, float]:
    """Return the largest linear (m/s) and angular (rad/s) speed of the free bodies."""
    speed, turn = np.linalg.norm(data.qvel.reshape(-1, 2, 3), axis=2).max(axis=0, initial=0.0)
    return float(speed), float(turn)
