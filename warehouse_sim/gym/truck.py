"""The truck of one episode: where it is, where it thinks that it is, what it touches, and where it goes in."""

from dataclasses import replace
from typing import Any

import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.belief import Aim
from warehouse_sim.benchmark.docking.closed_loop.drive import COLLIDED
from warehouse_sim.benchmark.docking.closed_loop.episode import estimate_of
from warehouse_sim.benchmark.docking.closed_loop.settings import DRIFTS, DRIVE
from warehouse_sim.benchmark.docking.closed_loop.starts import Start, collisions_of
from warehouse_sim.benchmark.docking.closed_loop.vehicle import Motion, Odometry
from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, TINE_LENGTH, TINE_THICKNESS
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z
from warehouse_sim.gym.command import Command
from warehouse_sim.scene.viewpoints.drives import FloorPose
from warehouse_sim.scene.viewpoints.mountings import FORK_TRAVEL_HEIGHT, FORKLIFT, pose_on_floor
from warehouse_sim.schema import Viewpoint

TICKS = 2
"""Of the closed loop in one step: 0.1 s."""
STAND = FORKLIFT.front + TINE_LENGTH + DRIVE.tip_gap
"""From the truck's origin to the entry (m) where the closed loop stops steering: the tips are 10 cm before the face."""
_LOOK_AROUND = 0.1
"""Way (m) after which it is checked again whether the truck touches something, as in the closed loop."""


class Truck:
    """A truck on its way to one pallet.

    Args:
        start: Of the episode.
        rng: Samples the errors of odometry, and how the forks hang when they go in.
    """

    def __init__(self, start: Start, rng: np.random.Generator) -> None:
        self.start, self._rng = start, rng
        self.motion = Motion(start.pose)
        self.odometry = Odometry(FloorPose(0.0, 0.0, 0.0), DRIFTS["usual"], rng)
        self.time = self.driven = 0.0
        self._touches = collisions_of(start.station.scene, start, with_pallet=True)

    @property
    def T_world_dock(self) -> Transform:
        """The true entry."""
        return self.start.pallet.T_world_object @ self.start.face.T_object_dock

    @property
    def aim(self) -> Aim:
        """Where the true entry is from the truck."""
        return Aim.of(self.T_world_dock, self.T_world_vehicle)

    @property
    def T_world_vehicle(self) -> Transform:
        """Where it is."""
        pose = self.motion.pose
        return pose_on_floor(pose.x, pose.y, pose.yaw)

    @property
    def tines(self) -> float:
        """Height of the middle of the tines over the floor (m), while it drives."""
        return FORK_TRAVEL_HEIGHT + self.start.mount.lift - TINE_THICKNESS / 2.0

    @property
    def T_vehicle_camera(self) -> Transform:
        """Where its camera is mounted."""
        view = self.start.mount.view(self.motion.pose)
        return invert(self.T_world_vehicle) @ view.T_world_camera

    def viewpoint(self) -> Viewpoint:
        """Return where its camera is and how it moves."""
        pose, speed = self.motion.pose, self.motion.speed
        return replace(
            self.start.mount.view(pose),
            velocity=(float(speed * np.cos(pose.yaw)), float(speed * np.sin(pose.yaw)), 0.0),
            yaw_rate=float(speed * self.motion.curvature),
            time=self.time,
        )

    def known(self, camera: PinholeCamera) -> dict[str, Any]:
        """Return what the truck's computer knows of an episode, for ``camera``; see ``Docking.reset``."""
        sent = invert(self.T_world_vehicle) @ np.append(self.start.commanded, 1.0)
        return {
            "obj_id": self.start.station.scene.model_of(self.start.pallet).obj_id,
            "sent": sent[:3],
            "tines": self.tines,
            "K": camera.K,
            "T_vehicle_camera": self.T_vehicle_camera,
        }

    def obey(self, command: Command) -> str:
        """Drive for a step or go in; return how the episode ends, "" where it goes on."""
        if command.goes_in:
            pallet, face = self.start.pallet, self.start.face
            T = estimate_of(self._entry(command), pallet.T_world_object, face.T_object_dock)
            return dock(self.start.station, face, T, self._rng).outcome
        for _ in range(TICKS):
            self.motion, way = self.motion.after(command.speed, command.curvature)
            self.odometry.add(way, self.motion.curvature)
            before, self.driven, self.time = self.driven, self.driven + way, self.time + DRIVE.tick
            crossed = int(self.driven / _LOOK_AROUND) > int(before / _LOOK_AROUND)
            if crossed and self._touches(self.motion.pose):
                return COLLIDED
        return ""

    def _entry(self, command: Command) -> Transform:
        """Return the dock frame that an order to go in stands for; its way is by odometry."""
        ahead = FORKLIFT.front + command.way / self.odometry.scale + HEEL_GAP
        place = (self.T_world_vehicle @ np.array([ahead, 0.0, self.tines + command.up, 1.0]))[:3]
        return make_transform(rotation_z(self.motion.pose.yaw), place)
