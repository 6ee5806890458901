"""One docking: the truck drives along the estimated dock frame, and the true pallet answers."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from jaxtyping import Float

from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.benchmark.docking.world import FORKS, LOAD, PALLET, build, heading, nearest_along
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, TINE_LENGTH, TINE_THICKNESS, DockingFace
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import Transform, invert, rotation_angle, transform_points

Outcome = Literal["docked", "struck", "pushed", "not lifted", "fell", "rejected"]
_LOOK_EVERY = 5
"""Steps between two looks at the pallet and two orders to the servos; forces are felt in every step."""
_SETTLE, _HOLD = 0.2, 0.3
"""How long things come to rest before the truck drives, and after it arrived and lifted (s)."""

Watcher = Callable[[mujoco.MjModel, mujoco.MjData], None]
"""Is shown the model at every look."""


@dataclass(frozen=True)
class Docking:
    """What became of one docking."""

    outcome: Outcome
    by: str = ""
    """What of the forks touched what: "tip > deck", or why the truck would not drive."""
    force: float = 0.0
    """Greatest force of the forks on anything while they went in (N), as ``Truck.force_time`` says."""
    push: float = 0.0
    """Greatest way of a corner of the pallet while the forks went in (m)."""
    inside: float = 0.0
    """How far behind the true face the tips came (m)."""
    time: float = 0.0
    """Simulated (s)."""

    @property
    def docked(self) -> bool:
        """Whether the pallet was taken."""
        return self.outcome == "docked"


def dock(
    station: Station,
    face: DockingFace,
    T_object_estimated: Transform,
    rng: np.random.Generator,
    watch: Watcher | None = None,
) -> Docking:
    """Simulate what an estimate of a pallet leads to.

    The truck stands level: it takes yaw, place and pitch of the estimated dock frame, and no roll. The lift follows the
    drive, so that the heels stay on the estimated axis, as far down as the lift goes.

    Args:
        station: The true pallet and what is around it.
        face: The side that is approached.
        T_object_estimated: The estimate in the true object frame, under the best symmetry.
        rng: Where the forks hang in the play of the sideshifter.
        watch: Sees the model at every look.
    """
    T_world_dock = station.pallet.T_world_object @ T_object_estimated @ face.T_object_dock
    problem = _rejection(station, face, T_world_dock)
    if problem:
        return Docking("rejected", problem)
    aside = [(invert(face.T_object_dock) @ pocket.T_object_pocket)[1, 3] for pocket in face.pockets]
    model = build(station, T_world_dock, np.array(aside))
    corners = transform_points(station.pallet.T_world_object, box_corners(station.scene.model_of(station.pallet).size))
    stop = -HEEL_GAP
    start = min(nearest_along(T_world_dock, corners) - TRUCK.start_gap - TINE_LENGTH, stop)
    run = _Run(model, station, T_world_dock, watch)
    return run.all(start, stop, float(rng.uniform(-TRUCK.side_play, TRUCK.side_play)), face)


def _rejection(station: Station, face: DockingFace, T_world_dock: Transform) -> str:
    """Return why the truck knows, without touching anything, that it cannot drive to an estimate."""
    true = station.pallet.T_world_object @ face.T_object_dock
    if T_world_dock[2, 2] <= 0.0:
        return "upside down"
    if T_world_dock[:3, 0] @ true[:3, 0] <= 0.0:  # it stands before this side and would have to come out of it
        return "reversed"
    low, high = TRUCK.max_tilt
    return "" if low <= heading(T_world_dock)[1] <= high else "beyond the tilt of the mast"


def _lowest(T_world_dock: Transform) -> float:
    """Return the least way of the lift, counted from the dock frame (m)."""
    pitch, thickness = heading(T_world_dock)[1], TINE_THICKNESS
    under = thickness / 2.0 * np.cos(pitch) + thickness * max(np.sin(pitch), 0.0)
    return float(TRUCK.lowest + under - T_world_dock[2, 3])


class _Run:
    """The simulation of one docking."""

    def __init__(
        self,
        model: mujoco.MjModel,
        station: Station,
        T_world_dock: Transform,
        watch: Watcher | None,
    ) -> None:
        self.model, self.data, self.watch = model, mujoco.MjData(model), watch
        self.pitch = heading(T_world_dock)[1]
        self.lowest = _lowest(T_world_dock)
        self.corners = box_corners(station.scene.model_of(station.pallet).size)
        self.of_forks = np.array([model.geom(index).name.startswith(FORKS) for index in range(model.ngeom)])
        self.recent: deque[float] = deque(maxlen=max(round(TRUCK.force_time / model.opt.timestep), 1))
        self.force = self.push = 0.0
        self.touched = ""

    def all(self, start: float, stop: float, hangs: float, face: DockingFace) -> Docking:
        """Settle, drive in, lift; stop at the first failure."""
        data = self.data
        self._send(start)
        data.joint("drive").qpos, data.joint("lift").qpos = data.actuator("drive").ctrl, data.actuator("lift").ctrl
        data.joint("side_play").qpos = hangs
        self._steps(round(_SETTLE / self.model.opt.timestep))
        self.before = self._pose(PALLET)
        outcome = self._drive_in(start, stop)
        inside = self._inside(face)
        if outcome is None:
            outcome = self._lift()
        return Docking(outcome, self.touched, self.force, self.push, inside, float(data.time))

    def _drive_in(self, start: float, stop: float) -> Outcome | None:
        looks = int(np.ceil(((stop - start) / TRUCK.speed + _HOLD) / (_LOOK_EVERY * self.model.opt.timestep)))
        for look in range(looks):
            self._send(min(start + (look + 1) * _LOOK_EVERY * self.model.opt.timestep * TRUCK.speed, stop))
            for _ in range(_LOOK_EVERY):
                self._steps(1)
                self._feel()
            self._show()
            failure = self._failure()
            if failure is not None:
                return failure
        return None

    def _feel(self) -> None:
        """Add what this step's contacts exert: only the sum over steps is the momentum that a stiff touch transfers."""
        force, by = self._force_of_forks()
        self.recent.append(force)
        self.touched = by or self.touched
        self.force = max(self.force, sum(self.recent) / TRUCK.force_time * self.model.opt.timestep)

    def _failure(self) -> Outcome | None:
        """Look at the pallet while the forks go in."""
        moved = transform_points(self._pose(PALLET), self.corners) - transform_points(self.before, self.corners)
        self.push = max(self.push, float(np.linalg.norm(moved, axis=1).max()))
        if self.force > TRUCK.max_force:
            return "struck"
        return "pushed" if self.push > TRUCK.max_push else None

    def _lift(self) -> Outcome:
        """Lift until the pallet is up, hold, and look at pallet and load."""
        data = self.data
        at, load = self._pose(PALLET), self._load_on_pallet()
        look = _LOOK_EVERY * self.model.opt.timestep
        bottom = float(data.actuator("lift").ctrl[0])
        for count in range(int(TRUCK.max_lift / TRUCK.lift_speed / look)):
            data.actuator("lift").ctrl = bottom + (count + 1) * look * TRUCK.lift_speed
            self._steps(_LOOK_EVERY)
            self._show()
            if self._risen(at) >= TRUCK.raised or self._leans(at):
                break
        self._steps(round(_HOLD / self.model.opt.timestep))
        now = self._pose(PALLET)
        if self._leans(at) or np.linalg.norm(now[:2, 3] - at[:2, 3]) > TRUCK.max_slip:
            return "fell"
        if self._risen(at) < TRUCK.raised / 2.0:
            return "not lifted"
        if load is not None:
            slipped = invert(load) @ self._load_on_pallet()
            if (
                np.linalg.norm(slipped[:3, 3]) > TRUCK.max_slip
                or rotation_angle(slipped[:3, :3], np.eye(3)) > TRUCK.max_lean
            ):
                return "fell"
        return "docked"

    def _risen(self, at: Transform) -> float:
        """Return by how much the corner that rose least is up (m): a pallet tipped about its far edge is not lifted."""
        now = transform_points(self._pose(PALLET), self.corners)
        return float((now - transform_points(at, self.corners))[:, 2].min())

    def _leans(self, at: Transform) -> bool:
        return bool(self._pose(PALLET)[:3, 2] @ at[:3, 2] < np.cos(TRUCK.max_lean))

    def _load_on_pallet(self) -> Transform | None:
        if mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, LOAD) < 0:
            return None
        return invert(self._pose(PALLET)) @ self._pose(LOAD)

    def _force_of_forks(self) -> tuple[float, str]:
        """Return the sum (N) of all contact forces on the forks and what the greatest is between."""
        data, total, greatest, by = self.data, 0.0, 0.0, ""
        if data.ncon == 0:
            return 0.0, ""
        pairs, wrench = data.contact.geom, np.zeros(6)
        for index in np.flatnonzero(self.of_forks[pairs].any(axis=1)):
            mujoco.mj_contactForce(self.model, data, int(index), wrench)
            force = float(np.linalg.norm(wrench[:3]))
            total += force
            if force > greatest:
                greatest, by = force, self._between(pairs[index])
        return total, by

    def _between(self, pair: Float[np.ndarray, " 2"]) -> str:
        forks, other = sorted(pair, key=lambda geom: not self.of_forks[geom])
        names = [self.model.geom(int(geom)).name.split(":") for geom in (forks, other)]
        what = names[1][1] if names[1][0] == PALLET else names[1][0]
        return f"{names[0][1]} > {what}"

    def _inside(self, face: DockingFace) -> float:
        forks = self.data.body(FORKS)
        tips = forks.xpos + forks.xmat.reshape(3, 3) @ [TINE_LENGTH, 0.0, 0.0]
        return float((invert(self._pose(PALLET) @ face.T_object_dock) @ np.append(tips, 1.0))[0])

    def _send(self, place: float) -> None:
        """Send the heels to a place on the estimated axis (m), or over it where the lift goes no lower."""
        self.data.actuator("drive").ctrl = place * np.cos(self.pitch)
        self.data.actuator("lift").ctrl = max(place * np.sin(self.pitch), self.lowest)

    def _steps(self, count: int) -> None:
        mujoco.mj_step(self.model, self.data, nstep=count)

    def _show(self) -> None:
        if self.watch is not None:
            self.watch(self.model, self.data)

    def _pose(self, body: str) -> Transform:
        data, T = self.data.body(body), np.eye(4)
        T[:3, :3], T[:3, 3] = data.xmat.reshape(3, 3), data.xpos
        return T
