"""A scene as a MuJoCo model: what is fixed as geoms of the world, what is loose as bodies with a free joint."""

from collections.abc import Iterable, Sequence

import mujoco
import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import invert, quat_wxyz_from_matrix
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

FRICTION = (0.5, 0.005, 0.0001)
"""Sliding, torsional and rolling friction: wood, board and painted steel on each other slide at 0.3-0.6."""
CONTACT_TIME, CONTACT_DAMPING = 0.006, 1.5
"""Time constant of the contact's spring (s), at least twice the time step, and its damping ratio.

Damped beyond the critical 1 a box under a heavy stack, or a stiff pallet on beams that are not quite level, comes to
rest instead of trembling.
"""
CONTACT_IMPEDANCE = (0.95, 0.99, 0.0005, 0.5, 2.0)
"""Stiff contacts: a stack of ten cartons sinks in by a fraction of a millimetre."""
TIME_STEP = 0.002
"""Seconds of one step."""
_UPRIGHT, _NO_TURN = np.eye(3), np.array([1.0, 0.0, 0.0, 0.0])
_ARENA_BYTES = 1 << 28
"""MuJoCo's default arena overflows at a few thousand contacts."""


def to_mjspec(
    scene: SceneSpec,
    instances: Iterable[ObjectInstance] | None = None,
    solids: Sequence[OrientedBox] = (),
    blocks: Iterable[Sequence[ObjectInstance]] = (),
) -> mujoco.MjSpec:
    """Build the MuJoCo specification of ``instances`` of ``scene``, of all by default.

    Bodies and geoms are named after the instance id: body "3", geoms "3:0", "3:1", ...

    Args:
        scene: Where the models come from.
        instances: What to build, at its own poses.
        solids: More fixed boxes, in the world: what the instances may touch.
        blocks: Objects that move as one body, named after the first of them, whose pose is the body's.
    """
    spec = mujoco.MjSpec()
    spec.modelname = f"scene_{scene.scene_index:06d}"
    spec.memory = _ARENA_BYTES
    spec.option.timestep = TIME_STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.default.geom.solref = (CONTACT_TIME, CONTACT_DAMPING)
    spec.default.geom.solimp = CONTACT_IMPEDANCE
    spec.default.geom.friction = FRICTION
    for box in solids:
        _add_box(spec.worldbody, box)
    for instance in scene.instances if instances is None else instances:
        body, model = _add_body(spec, instance), scene.model_of(instance)
        if instance.dynamic:
            body.add_freejoint()
        _add_solids(body, instance, model, model.collision)
    for block in blocks:
        body, T_first_world = _add_body(spec, block[0]), invert(block[0].T_world_object)
        body.add_freejoint()
        for item in block:
            model = scene.model_of(item)
            placed = [box.placed(T_first_world @ item.T_world_object) for box in model.collision]
            _add_solids(body, item, model, placed)
    return spec


def _add_body(spec: mujoco.MjSpec, item: ObjectInstance) -> mujoco.MjsBody:
    T = item.T_world_object
    return spec.worldbody.add_body(name=str(item.instance_id), pos=T[:3, 3], quat=quat_wxyz_from_matrix(T[:3, :3]))


def _add_solids(body: mujoco.MjsBody, item: ObjectInstance, model: ObjectModel, boxes: Sequence[OrientedBox]) -> None:
    """Add the boxes of an object to the body that it moves with, its mass spread by their volumes."""
    volumes = [float(np.prod(box.size)) for box in boxes]
    for index, (box, volume) in enumerate(zip(boxes, volumes, strict=True)):
        _add_box(body, box, name=f"{item.instance_id}:{index}", mass=model.mass * volume / sum(volumes))


def _add_box(body: mujoco.MjsBody, box: OrientedBox, **settings: str | float) -> None:
    rotation = box.T_parent_box[:3, :3]
    upright = (rotation == _UPRIGHT).all()
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=box.size / 2,
        pos=box.T_parent_box[:3, 3],
        quat=_NO_TURN if upright else quat_wxyz_from_matrix(rotation),
        **settings,
    )
