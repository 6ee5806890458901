"""Loads that something ran into: the one source of leaning and fallen goods.

An impulse is a horizontal blow to the uppermost pieces of a load at rest; the simulation decides what follows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import mujoco
import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, matrix_from_quat_wxyz
from warehouse_sim.physics.rest import Blow, Rest, RestLimits, Stack, boxes_around, bring_to_rest
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import ObjectInstance, SceneSpec

_GOODS = ("carton", "tote", "drum", "sack")
"""Classes that an impulse moves."""
_BONDS = ("wrap", "corner_post")
"""Classes that hold a load together: such a load is left alone."""
_REACH = (1.6, 1.6, 0.2)
"""How far around a load (m, along each axis) things stay where they are while its pieces fall; all below counts."""
_TRIES = 4
_HEIGHT = Distribution.uniform(0.0, 0.45)
"""Where a blow lands: fraction of a piece's height above its centre; the higher, the more it tips."""
_MAX_TIME = 6.0
"""Longest simulated time until all lie still (s); an impulse that takes longer is sampled again."""


@dataclass(frozen=True)
@ranged
class ImpulseConfig:
    """How often and how hard loads are struck."""

    fraction: Fraction = 0.0
    """Fraction of the loads with goods on them, and nothing on top, that get an impulse, 0-1."""
    speed: Annotated[Distribution, Range(0, 5, "m/s")] = field(default=Distribution.uniform(0.5, 2.4))
    """Speed that the blow gives to the uppermost piece (m/s), 0-5; pieces further down get less by their height."""
    pieces: Annotated[Distribution, Range(1, 1000, whole=True)] = field(default=Distribution.uniform(1, 8))
    """Pieces that are hit, from the top down, a whole number, 1-1,000."""


@dataclass(frozen=True, eq=False)
class Impulses:
    """What the impulses of a scene did."""

    poses: dict[int, Transform]
    """New T_world_object of the pieces of struck loads by instance id."""
    rests: tuple[Rest, ...]
    """How each struck load came to rest."""
    groups: tuple[int, ...]
    """Their groups."""


def impulse_loads(
    scene: SceneSpec,
    stacks: Sequence[Stack],
    solids: Solids,
    limits: RestLimits,
    config: ImpulseConfig,
) -> Impulses:
    """Give impulses to a fraction of the loads of a scene at rest, whose collision boxes are ``solids``.

    A load whose pieces do not come to rest in any of a few impulses stays as it was.
    """
    poses: dict[int, Transform] = {}
    rests, groups = [], []
    if config.fraction > 0.0:
        rng = scene_rng(scene.seed, scene.scene_index, "impulses")
        limits = RestLimits(limits.speed, limits.turn, _MAX_TIME)
        bound = {item.group for item in scene.instances if scene.model_of(item).class_name in _BONDS}
        where = {item.instance_id: item for item in scene.instances}
        loads = [_top_load([where[item.instance_id] for item in stack]) for stack in stacks]
        for load in loads:
            goods = [item for item in load if scene.model_of(item).class_name in _GOODS]
            if len(goods) == len(load) or not goods or load[0].group in bound or rng.random() >= config.fraction:
                continue
            rest = _impulse(scene, load, goods, solids, limits, config, rng)
            if rest is not None:
                solids = solids.moved(rest.moved(load), scene.models)
                poses |= rest.poses
                rests.append(rest)
                groups.append(load[0].group)
    return Impulses(poses, tuple(rests), tuple(groups))


def _top_load(stack: Sequence[ObjectInstance]) -> list[ObjectInstance]:
    """Return the pieces of the uppermost load of a stack: the one that carries no other."""
    highest = max(stack, key=lambda item: item.T_world_object[2, 3])
    return [item for item in stack if item.group == highest.group]


def _impulse(
    scene: SceneSpec,
    load: list[ObjectInstance],
    goods: list[ObjectInstance],
    solids: Solids,
    limits: RestLimits,
    config: ImpulseConfig,
    rng: np.random.Generator,
) -> Rest | None:
    """Draw impulses until the load comes to rest after one; None when it never does."""
    low, _ = solids.extent_of([item.instance_id for item in load])
    boxes = boxes_around(solids, load, (_REACH[0], _REACH[1], low[2] + _REACH[2]))
    for _ in range(_TRIES):
        rest = bring_to_rest(scene, load, boxes, limits, _sample_blow(scene, goods, config, rng))
        if rest.within(limits) and _inside(rest, low, solids):
            return rest
    return None


def _sample_blow(
    scene: SceneSpec, goods: list[ObjectInstance], config: ImpulseConfig, rng: np.random.Generator
) -> Blow:
    """Return a blow from any side against the uppermost pieces."""
    order = rng.permutation(len(goods))
    uppermost = sorted((goods[index] for index in order), key=lambda item: -round(item.T_world_object[2, 3], 2))
    hit = uppermost[: max(1, config.pieces.sample_count(rng))]
    bearing = rng.uniform(-np.pi, np.pi)
    velocity = config.speed.sample(rng) * np.array([np.cos(bearing), np.sin(bearing), 0.0])
    height = _HEIGHT.sample(rng)
    foot = min(item.T_world_object[2, 3] for item in goods) - 0.5 * float(scene.model_of(goods[0]).size[2])
    top = hit[0].T_world_object[2, 3] - foot

    def blow(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        for item in hit:
            fraction = (item.T_world_object[2, 3] - foot) / top
            _strike(model, data, item, fraction * velocity, height * float(scene.model_of(item).size[2]))

    return blow


def _strike(
    model: mujoco.MjModel, data: mujoco.MjData, item: ObjectInstance, velocity: Float[np.ndarray, " 3"], arm: float
) -> None:
    """Give a body ``velocity`` (m/s) by one blow that lands ``arm`` (m) above its centre: it also begins to turn."""
    body = model.body(str(item.instance_id))
    impulse = model.body_mass[body.id] * velocity
    moment = np.cross([0.0, 0.0, arm], impulse)
    R_body_inertia = matrix_from_quat_wxyz(model.body_iquat[body.id])
    R_inertia_world = (item.T_world_object[:3, :3] @ R_body_inertia).T
    turn = R_body_inertia @ (R_inertia_world @ moment / model.body_inertia[body.id])
    start = model.jnt_dofadr[model.body_jntadr[body.id]]
    data.qvel[start : start + 3] = velocity
    data.qvel[start + 3 : start + 6] = turn


def _inside(rest: Rest, low: Float[np.ndarray, " 3"], solids: Solids) -> bool:
    """Return whether no piece went further than the surroundings that were built, or through the floor."""
    places = np.array([T[:3, 3] for T in rest.poses.values()])
    near = np.abs(places[:, :2] - low[:2]).max() < _REACH[0] + 1.0
    return bool(near and places[:, 2].min() > 0.0)
