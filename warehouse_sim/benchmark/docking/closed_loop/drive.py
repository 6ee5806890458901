"""One approach: see, estimate, filter, steer, until the truck stands before the entry, or gives up."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.belief import Aim, Believed
from warehouse_sim.benchmark.docking.closed_loop.settings import DRIFTS, DRIVE, Condition
from warehouse_sim.benchmark.docking.closed_loop.vehicle import Motion, Odometry, pursue, slow_down, wheel_for
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.benchmark.docking.world import heading
from warehouse_sim.estimators.tracking.tracker import View, in_sight
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, TINE_LENGTH
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_y, rotation_z
from warehouse_sim.scene.viewpoints.drives import FloorPose, Mount
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT, pose_on_floor
from warehouse_sim.schema import PoseEstimate, Viewpoint

ARRIVED = "arrived"
ABORTS = ("no estimate", "unsure", "misaligned", "out of reach", "timed out")
"""Why a truck stops by itself; it touched nothing."""
DOCKED, COLLIDED = "docked", "collided"
"""How an approach ends well, and where something was in the way."""
_THERE, _CREEP = 1e-3, 0.01
"""So near (m) the truck has arrived, and it never drives slower (m/s) before."""
_LOOK_AROUND = 0.1
"""Way (m) after which it is checked again whether the truck touches something."""


class Glance(NamedTuple):
    """One image to be estimated."""

    viewpoint: Viewpoint
    """Where the truck truly is."""
    T_odom_camera: Transform
    """Where it thinks that its camera is."""
    index: int  # type: ignore[assignment]  # a tuple has a method of that name
    """Of the image."""
    driven: float
    """Way so far (m)."""


class Perceive(Protocol):
    """Whoever estimates the pallet that the truck was sent to."""

    @property
    def min_score(self) -> float:
        """Scores below this do not count."""

    def __call__(self, glance: Glance, /) -> PoseEstimate | None:
        """Return an estimate with a covariance, None where there is none."""


@dataclass
class Approach:
    """What became of an approach."""

    ended: str
    """``ARRIVED``, ``COLLIDED`` or one of ``ABORTS``."""
    T_world_dock: Transform | None
    """The dock frame that the truck truly drives in along; None where it does not."""
    time: float
    distance: float
    corrections: int
    images: int
    way: list[FloorPose] = field(default_factory=list)
    """True poses of the truck, one for each tick."""
    believed: list[Transform] = field(default_factory=list)
    """Entries that it believed in, one after the other (odometry frame)."""


@dataclass(eq=False)
class Approacher:
    """A truck on its way to one pallet.

    Args:
        mount: Its camera.
        camera: Intrinsics.
        believed: Of the pallet; empty.
        perceive: Estimates.
        condition: Delay, drift, whether the loop is closed.
        touches: Whether the truck at a true pose touches anything but the pallet.
    """

    mount: Mount
    camera: PinholeCamera
    believed: Believed
    perceive: Perceive
    condition: Condition
    touches: Callable[[FloorPose], bool]

    def run(self, start: FloorPose, rng: np.random.Generator) -> Approach:
        """Drive from ``start``; ``rng`` draws the errors of odometry."""
        self.motion, self.odometry = Motion(start), Odometry(start, DRIFTS[self.condition.drift], rng)
        self.time = self.distance = self.away = 0.0
        self.images = self.missed = 0
        self.unsure = False
        self.pending: deque[tuple[float, View, Transform, PoseEstimate]] = deque()
        self.way, self.entries = [start], list[Transform]()
        ended = ""
        while not ended:
            self._look()
            self._receive()
            ended = self._stops() or self._roll()
        T_world_dock = self._driven_in() if ended == ARRIVED else None
        return Approach(
            ended,
            T_world_dock,
            self.time,
            self.distance,
            self.believed.corrections,
            self.images,
            self.way,
            self.entries,
        )

    @property
    def stand(self) -> float:
        """From the truck's origin to the entry where it stops steering (m)."""
        return FORKLIFT.front + TINE_LENGTH + DRIVE.tip_gap

    def _look(self) -> None:
        """Take an image where one is due; the open loop takes none after its first estimate."""
        is_due = self.time >= self.images * DRIVE.period - 1e-9
        knows = self.believed.T_odom_object is not None or bool(self.pending)
        if not is_due or (self.condition.is_open and knows):
            return
        pose, speed = self.motion.pose, self.motion.speed
        view = self.mount.view(pose)
        assert view.T_world_vehicle is not None  # a mount stands on a vehicle
        T_vehicle_camera = invert(view.T_world_vehicle) @ view.T_world_camera
        viewpoint = Viewpoint(
            view.T_world_camera,
            view.kind,
            view.T_world_vehicle,
            velocity=(float(speed * np.cos(pose.yaw)), float(speed * np.sin(pose.yaw)), 0.0),
            yaw_rate=float(speed * self.motion.curvature),
            time=self.time,
        )
        T_odom_camera = self.odometry.T_odom_vehicle @ T_vehicle_camera
        glance = Glance(viewpoint, T_odom_camera, self.images, self.distance)
        found = self.perceive(glance)
        self.images += 1
        if found is not None and not found.rejected and found.score >= self.perceive.min_score:
            stamp = View(0, self.images, self.camera, T_odom_camera, self.time)
            self.pending.append((self.time + self.condition.delay, stamp, T_vehicle_camera, found))
            self.missed, self.unsure = 0, False
        elif self._should_see(T_odom_camera):
            self.missed, self.unsure = self.missed + 1, self.unsure or found is not None

    def _should_see(self, T_odom_camera: Transform) -> bool:
        """Return whether an estimate is missed: the pallet should be in the image, and is not yet right ahead."""
        if self.believed.T_odom_object is None:
            return True
        aim = Aim.of(self.believed.entry(T_odom_camera), self.odometry.T_odom_vehicle)
        tips = aim.along - FORKLIFT.front - TINE_LENGTH
        here = View(0, self.images, self.camera, T_odom_camera, self.time)
        return tips > DRIVE.blind and in_sight(here, self.believed.T_odom_object[:3, 3])

    def _receive(self) -> None:
        while self.pending and self.pending[0][0] <= self.time + 1e-9:
            _, view, T_vehicle_camera, found = self.pending.popleft()
            if not self.condition.compensated:
                T_now = self.odometry.T_odom_vehicle @ T_vehicle_camera
                view = View(view.scene_id, view.image_id, view.camera, T_now, view.time)
            self.believed.take(view, found)
            self.entries.append(self.believed.entry(view.T_world_camera))

    def _stops(self) -> str:
        if self.missed >= DRIVE.patience:
            return "unsure" if self.unsure else "no estimate"
        if self.time > DRIVE.max_time:
            return "timed out"
        return ""

    def _roll(self) -> str:
        """Drive for a tick; return why it ends, "" where it goes on."""
        speed = curvature = 0.0
        if self.entries:
            aim = self._aim()
            left = aim.along - self.stand
            if abs(aim.turned) > DRIVE.max_bearing:
                # A first wrong pose may be outvoted: the truck waits for some more images.
                self.away += DRIVE.tick
                if self.away > DRIVE.patience * DRIVE.period:
                    return "out of reach"
            elif left <= _THERE:
                return self._arrived(aim)
            else:
                # The last millimetres are crept: at the speed of braking the truck would take forever.
                speed = max(slow_down(left), _CREEP)
                curvature = pursue(left, aim.aside, aim.turned)
                if abs(wheel_for(curvature) - self.motion.steering) > DRIVE.wheel_off:
                    speed = min(speed, DRIVE.slow)
        self.motion, way = self.motion.after(speed, curvature)
        self.time, self.distance = self.time + DRIVE.tick, self.distance + way
        self.odometry.add(way, self.motion.curvature)
        self.way.append(self.motion.pose)
        crossed = int(self.distance / _LOOK_AROUND) > int((self.distance - way) / _LOOK_AROUND)
        return COLLIDED if crossed and self.touches(self.motion.pose) else ""

    def _arrived(self, aim: Aim) -> str:
        beside = aim.aside + aim.along * np.tan(aim.turned)
        off = abs(beside) > DRIVE.max_lateral or abs(aim.turned) > DRIVE.max_yaw
        return "misaligned" if off else ARRIVED

    def _aim(self) -> Aim:
        return Aim.of(self.entries[-1], self.odometry.T_odom_vehicle)

    def _driven_in(self) -> Transform:
        """Return the dock frame along which the truck goes in: its own axis, as far as odometry takes it for needed.

        Height and pitch of the forks are those that it believes in; its heading and where it stops are true.
        """
        T_odom_dock, pose = self.entries[-1], self.motion.pose
        heel = FORKLIFT.front
        ahead = self.odometry.T_odom_vehicle[:2, 0]
        to_entry = float(ahead @ (T_odom_dock[:2, 3] - self.odometry.T_odom_vehicle[:2, 3]))
        way = max(to_entry - heel - HEEL_GAP, 0.0) / self.odometry.scale
        self.distance += way
        self.time += way / TRUCK.speed
        T_world_vehicle = pose_on_floor(pose.x, pose.y, pose.yaw)
        forward = np.array([heel + way + HEEL_GAP, 0.0, float(T_odom_dock[2, 3])])
        _, pitch = heading(T_odom_dock)
        turn = rotation_z(pose.yaw) @ rotation_y(-pitch)
        return make_transform(turn, (T_world_vehicle @ np.append(forward, 1.0))[:3])
