"""Let a scene come to rest under gravity and say whether it did."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz
from warehouse_sim.physics.build import to_mjspec
from warehouse_sim.physics.check import contact_state
from warehouse_sim.physics.report import SettleReport
from warehouse_sim.schema import SceneSpec

_CHECK_EVERY = 5
"""Steps between two looks at the speeds; two quiet looks in a row are rest, as a turning point has no speed either."""


@dataclass(frozen=True)
class SettleConfig:
    """When a scene is at rest, and how far it may have moved by then."""

    max_time: float = 3.0
    """Longest simulated time (s), 0.1-60."""
    rest_speed: float = 0.002
    """At rest every body is slower than this (m/s), > 0."""
    rest_turn: float = 0.01
    """At rest every body turns slower than this (rad/s), > 0."""
    max_overlap_mm: float = 1.0
    """Deepest overlap allowed (mm), > 0."""
    max_gap_mm: float = 1.0
    """Largest gap allowed under a loose object (mm), > 0."""
    max_drift_mm: float = 30.0
    """Largest way allowed from first to last place (mm), > 0."""
    max_tilt_deg: float = 3.0
    """Largest tilt allowed against the first orientation (deg), > 0; beyond it a body has toppled."""

    def __post_init__(self) -> None:
        if not 0.1 <= self.max_time <= 60.0:
            raise ValueError(f"max_time must be 0.1-60 s, found {self.max_time}")
        for name in ("rest_speed", "rest_turn", "max_overlap_mm", "max_gap_mm", "max_drift_mm", "max_tilt_deg"):
            if getattr(self, name) <= 0.0:
                raise ValueError(f"{name} must be > 0, found {getattr(self, name)}")


def settle_scene(spec: SceneSpec, config: SettleConfig) -> tuple[SceneSpec, SettleReport]:
    """Simulate ``spec`` until it rests; return it with its final poses, and the report."""
    loose = [item for item in spec.instances if item.dynamic]
    model = to_mjspec(spec).compile()
    data = mujoco.MjData(model)
    _run_until_rest(model, data, config)
    poses = {}
    for item in loose:
        joint = data.joint(model.body(str(item.instance_id)).jntadr[0])
        poses[item.instance_id] = make_transform(matrix_from_quat_wxyz(joint.qpos[3:]), joint.qpos[:3].copy())
    instances = tuple(
        replace(item, T_world_object=poses.get(item.instance_id, item.T_world_object)) for item in spec.instances
    )
    settled = replace(spec, instances=instances, settled=True)
    return settled, _report(spec, settled, data, config)


def _run_until_rest(model: mujoco.MjModel, data: mujoco.MjData, config: SettleConfig) -> None:
    quiet = 0
    while quiet < 2 and data.time < config.max_time and model.nv:
        mujoco.mj_step(model, data, nstep=_CHECK_EVERY)
        speed, turn = _speeds(data)
        quiet = quiet + 1 if speed < config.rest_speed and turn < config.rest_turn else 0


def _speeds(data: mujoco.MjData) -> tuple[float, float]:
    """Return the largest linear (m/s) and angular (rad/s) speed of the free bodies."""
    velocity = data.qvel.reshape(-1, 2, 3)
    speed, turn = np.linalg.norm(velocity, axis=2).max(axis=0, initial=0.0)
    return float(speed), float(turn)


def _report(before: SceneSpec, after: SceneSpec, data: mujoco.MjData, config: SettleConfig) -> SettleReport:
    ids, drift, tilt = _displacements(before, after)
    state = contact_state(after)
    speed, turn = _speeds(data)
    toppled = ids[tilt > np.deg2rad(config.max_tilt_deg)]
    problems = []
    if speed >= config.rest_speed or turn >= config.rest_turn:
        problems.append(f"still moving at {speed:.3f} m/s and {turn:.3f} rad/s after {data.time:.1f} s")
    problems += [
        f"object {i} toppled by {np.rad2deg(a):.1f} deg" for i, a in zip(ids, tilt, strict=True) if i in toppled
    ]
    problems += [
        f"object {i} moved by {1000 * way:.1f} mm"
        for i, way in zip(ids, drift, strict=True)
        if 1000 * way > config.max_drift_mm
    ]
    problems += [
        f"objects {a} and {b} overlap by {1000 * depth:.1f} mm"
        for (a, b), depth in zip(state.pairs, state.overlap, strict=True)
        if 1000 * depth > config.max_overlap_mm
    ]
    problems += [
        f"object {i} floats {1000 * gap:.1f} mm or more above its support"
        for i, gap in zip(state.loose, state.gap, strict=True)
        if 1000 * gap > config.max_gap_mm
    ]
    return SettleReport(
        scene_index=after.scene_index,
        seed=after.seed,
        duration=float(data.time),
        max_speed=speed,
        max_drift=float(drift.max(initial=0.0)),
        max_tilt=float(tilt.max(initial=0.0)),
        max_overlap=state.max_overlap,
        max_gap=state.max_gap,
        toppled=tuple(int(i) for i in toppled),
        problems=tuple(problems),
    )


def _displacements(
    before: SceneSpec, after: SceneSpec
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
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
